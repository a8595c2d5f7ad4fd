// Controllers of ros2_control, with the C functions of ROBOT.h and ROBOT_loops.h. Written by kinetostatics.
#include "ROBOT.h"
#include "ROBOT_loops.h"
extern "C" void ROBOT_loops_positions(const ROBOT_loops_state *state, double *values);  // of the joints PASSIVE

#include <algorithm>
#include <cmath>

#include "controller_interface/chainable_controller_interface.hpp"
#include "controller_interface/controller_interface.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/rclcpp.hpp"
#include "realtime_tools/realtime_publisher.hpp"
#include "sensor_msgs/msg/joint_state.hpp"

namespace PACKAGE {

using namespace controller_interface;
using rclcpp_lifecycle::State;
using sensor_msgs::msg::JointState;
using Names = std::vector<std::string>;
using Numbers = std::vector<double>;

const Names COORDINATES = {NAMES_OF_COORDINATES}, ACTUATORS = {NAMES_OF_ACTUATORS};
const Names MEASURED = {NAMES_OF_MEASURED}, PASSIVE = {NAMES_OF_PASSIVE};
const double NONE = std::nan("");

InterfaceConfiguration interfaces_of(const Names &joints, const Names &kinds)
{
    InterfaceConfiguration configuration{interface_configuration_type::INDIVIDUAL, {}};
    for (const auto &kind : kinds)
        for (const auto &joint : joints) configuration.names.push_back(joint + "/" + kind);
    return configuration;
}

// Commands the actuators' positions and efforts at the referenced coordinates, under the parameters load and gravity.
class PoseController : public ChainableControllerInterface {
public:
    CallbackReturn on_init() override
    {
        kinds_ = auto_declare<Names>("command_interfaces", {"position", "effort"});
        load_ = auto_declare<Numbers>("load", Numbers(6, 0.0));
        gravity_ = auto_declare<Numbers>("gravity", {0.0, 0.0, -9.81});
        return load_.size() == 6 && gravity_.size() == 3 ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
    }

    InterfaceConfiguration command_interface_configuration() const override { return interfaces_of(ACTUATORS, kinds_); }
    InterfaceConfiguration state_interface_configuration() const override { return interfaces_of({}, {}); }

    CallbackReturn on_activate(const State &) override
    {
        reference_interfaces_.assign(COORDINATES.size(), NONE);
        ROBOT_start(&state_);
        return CallbackReturn::SUCCESS;
    }

protected:
    std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override
    {
        std::vector<hardware_interface::CommandInterface> exported;
        reference_interfaces_.assign(COORDINATES.size(), NONE);
        for (size_t k = 0; k < COORDINATES.size(); ++k)
            exported.emplace_back(get_node()->get_name() + ("/" + COORDINATES[k]), "position", &reference_interfaces_[k]);
        return exported;
    }

    // References come from other controllers only, such as forward_command_controller with its topic.
    return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) override { return return_type::OK; }

    // Without a reference, or if it is out of reach, the commands stay as they are.
    return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) override
    {
        const Numbers &reference = reference_interfaces_;
        if (std::any_of(reference.begin(), reference.end(), [](double value) { return std::isnan(value); })) return return_type::OK;
        ROBOT_input input{SET_REFERENCE, {}, {}};
        ROBOT_output output;
        std::copy(load_.begin(), load_.end(), input.load);
        std::copy(gravity_.begin(), gravity_.end(), input.gravity);
        const int status = ROBOT_evaluate(&input, &state_, &output);
        if (!(IS_VALID)) {
            RCLCPP_WARN_THROTTLE(get_node()->get_logger(), *get_node()->get_clock(), 1000, "no command: status %d", status);
            return return_type::OK;
        }
        bool written = true;
        auto command = command_interfaces_.begin();
        for (const auto &kind : kinds_)
            for (size_t k = 0; k < ACTUATORS.size(); ++k)
                written &= (command++)->set_value(kind == "effort" ? output.actuator_forces[k] : output.actuators[k]);
        return written ? return_type::OK : return_type::ERROR;
    }

private:
    Names kinds_;
    Numbers load_, gravity_;
    ROBOT_state state_;
};

// Publishes the positions of the passive joints, with which robot_state_publisher shows closed loops.
class PassiveJointBroadcaster : public ControllerInterface {
public:
    CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }
    InterfaceConfiguration command_interface_configuration() const override { return interfaces_of({}, {}); }
    InterfaceConfiguration state_interface_configuration() const override { return interfaces_of(MEASURED, {"position"}); }

    CallbackReturn on_configure(const State &) override
    {
        publisher_ = std::make_unique<realtime_tools::RealtimePublisher<JointState>>(
            get_node()->create_publisher<JointState>("joint_states", rclcpp::SystemDefaultsQoS()));
        message_.name = PASSIVE;
        message_.position.resize(PASSIVE.size());
        return CallbackReturn::SUCCESS;
    }

    CallbackReturn on_activate(const State &) override
    {
        ROBOT_loops_start(&state_);
        return CallbackReturn::SUCCESS;
    }

    return_type update(const rclcpp::Time &time, const rclcpp::Duration &) override
    {
        const auto measured = [this](size_t k) { return state_interfaces_[k].get_optional().value_or(NONE); };
        const ROBOT_loops_input input{SET_MEASURED, {}, {}};
        ROBOT_loops_output output;
        const int status = ROBOT_loops_evaluate(&input, &state_, &output);
        if (status != LOOPS_OK) {
            RCLCPP_WARN_THROTTLE(get_node()->get_logger(), *get_node()->get_clock(), 1000, "open loops: status %d", status);
            return return_type::OK;
        }
        ROBOT_loops_positions(&state_, message_.position.data());
        message_.header.stamp = time;
        publisher_->try_publish(message_);
        return return_type::OK;
    }

private:
    JointState message_;
    std::unique_ptr<realtime_tools::RealtimePublisher<JointState>> publisher_;
    ROBOT_loops_state state_;
};

}  // namespace PACKAGE

PLUGINLIB_EXPORT_CLASS(PACKAGE::PoseController, controller_interface::ChainableControllerInterface)
PLUGINLIB_EXPORT_CLASS(PACKAGE::PassiveJointBroadcaster, controller_interface::ControllerInterface)
