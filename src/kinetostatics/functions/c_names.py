"""Names of a robot file in exported files: identifiers, also for CMake; escaped texts in comments of C and in Markdown. All
characters of names are printable, see :func:`kinetostatics.files.attributes.new_name`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

#: Keywords of C and C++, and macros of the included headers and of compilers.
_RESERVED = frozenset(
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class co_await "
    "co_return co_yield compl concept const const_cast consteval constexpr constinit continue decltype default delete do "
    "double dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable namespace "
    "new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast requires restrict "
    "return short signed sizeof static static_assert static_cast struct switch template this thread_local throw true try "
    "typedef typeid typename typeof union unsigned using virtual void volatile wchar_t while xor xor_eq BUFSIZ CLOCKS_PER_SEC "
    "EOF HUGE_VAL INFINITY NAN NULL errno i386 linux unix".split()
)
#: Names that files of C's library, namespaces of C++ or targets of CMake have.
_TAKEN = frozenset(
    "all assert clean complex ctype depend edit_cache errno fenv float help inttypes install iso646 limits "
    "list_install_components locale math package package_source rebuild_cache setjmp signal std stdarg stdbool stddef stdint "
    "stdio stdlib string test tgmath time wchar wctype".split()
)


def identifier(name: str) -> str:
    """Return a name as an identifier of ASCII letters that is valid in C, C++ and CMake, and as the name of a file."""
    plain = _plain(name)
    return f"robot_{plain}" if plain in _RESERVED or plain.lower() in _TAKEN else plain


def c_names(names: Iterable[str]) -> dict[str, str]:
    """Return for each name a unique identifier for a field of a struct in C and C++."""
    unique: dict[str, str] = {}
    for name in names:
        field = _plain(name)
        while field in _RESERVED or field in unique.values():
            field += "_"
        unique[name] = field
    return unique


def _plain(name: str) -> str:
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if plain[:1].isalpha() else f"robot_{plain}"


def c_comment(text: str) -> str:
    """Return a text for a comment of C or C++: ASCII without ``*`` and ``?``, as in the end of a comment and trigraphs."""
    return text.encode("unicode_escape").decode("ascii").replace("*", r"\x2a").replace("?", r"\x3f")


def markdown(text: str) -> str:
    """Return a text for a line of Markdown, where all its punctuation is literal."""
    return re.sub(r"(?!(?<=[^\W_])_(?=[^\W_]))[!-/:-@\[-`{-~]", r"\\\g<0>", text)
