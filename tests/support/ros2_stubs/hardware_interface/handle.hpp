#pragma once
#include <optional>
#include <string>

namespace hardware_interface {
class Handle {
public:
    Handle(const std::string &prefix_name, const std::string &interface_name, double *value_ptr)
        : name_(prefix_name + "/" + interface_name), value_(value_ptr) {}
    const std::string &get_name() const { return name_; }
    double *pointer() const { return value_; }

private:
    std::string name_;
    double *value_;
};

class CommandInterface : public Handle { using Handle::Handle; };
class StateInterface : public Handle { using Handle::Handle; };

class LoanedCommandInterface {
public:
    explicit LoanedCommandInterface(CommandInterface interface) : interface_(interface) {}
    template <typename T>
    [[nodiscard]] bool set_value(const T &value, unsigned int = 10) { *interface_.pointer() = value; return true; }

private:
    CommandInterface interface_;
};

class LoanedStateInterface {
public:
    explicit LoanedStateInterface(StateInterface interface) : interface_(interface) {}
    template <typename T = double>
    [[nodiscard]] std::optional<T> get_optional(unsigned int = 10) const { return *interface_.pointer(); }

private:
    StateInterface interface_;
};
}  // namespace hardware_interface
