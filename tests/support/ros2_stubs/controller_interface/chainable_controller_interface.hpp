#pragma once
#include "controller_interface/controller_interface_base.hpp"

namespace controller_interface {
class ChainableControllerInterface : public ControllerInterfaceBase {
public:
    return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) final
    {
        if (!in_chained_mode_ && update_reference_from_subscribers(time, period) != return_type::OK) return return_type::ERROR;
        return update_and_write_commands(time, period);
    }
    bool is_chainable() const final { return true; }
    std::vector<hardware_interface::CommandInterface> export_reference_interfaces() final
    {
        auto exported = on_export_reference_interfaces();
        if (exported.size() != reference_interfaces_.size()) throw std::runtime_error("sizes of reference interfaces");
        for (const auto &interface : exported)
            if (interface.get_name().find(get_node()->get_name()) != 0) throw std::runtime_error("names of reference interfaces");
        return exported;
    }
    bool set_chained_mode(bool chained_mode) final { return in_chained_mode_ = chained_mode, on_set_chained_mode(chained_mode); }

protected:
    virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() = 0;
    virtual bool on_set_chained_mode(bool) { return true; }
    virtual return_type update_reference_from_subscribers(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;
    virtual return_type update_and_write_commands(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;

    std::vector<double> reference_interfaces_;

private:
    bool in_chained_mode_ = false;
};
}  // namespace controller_interface
