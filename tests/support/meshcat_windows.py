"""A window of Meshcat that takes what is drawn, without a server."""

import html
import re

import meshcat
import numpy as np
from meshcat.commands import Delete, SetObject, SetProperty, SetTransform

import kinetostatics as ks


class Window:
    """Takes a visualizer's commands instead of a server."""

    def __init__(self):
        self.objects, self.transforms, self.properties, self.deleted, self.paths = {}, {}, {}, [], []
        self.animations = {}

    def send(self, command):
        path = command.path.lower()
        self.paths.append(path)
        if isinstance(command, SetObject):
            self.objects[path] = command.object
        elif isinstance(command, SetTransform):
            self.transforms[path] = np.asarray(command.matrix)
        elif isinstance(command, SetProperty):
            self.properties.setdefault(path, {})[command.key] = command.value
        elif isinstance(command, Delete):
            self.deleted.append(path)
            for found in (self.objects, self.transforms, self.properties):
                for key in [key for key in found if key == path or key.startswith(f"{path}/")]:
                    del found[key]
        else:
            self.animations[path] = command.lower()

    def vertices(self, path):
        """Vertices (n, 3) in world axes."""
        at = self.transforms.get(path, np.eye(4))
        surface = self.objects[path].geometry
        return getattr(surface, "surface", surface).vertices @ at[:3, :3].T + at[:3, 3]

    def words(self, path):
        """What is written at a path."""
        return html.unescape(re.sub(r"<[^>]*>", " ", self.objects[path].material.map.properties["image"].text))


def drawn(result, vis=None, **options):
    window = Window()
    node = ks.show(result, visualizer=meshcat.Visualizer(window=window) if vis is None else vis, **options)
    return window if vis is None else vis.window, node
