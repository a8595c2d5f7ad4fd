// Loads a controller by the name of its class, updates it once for each line of numbers, and prints what it commands or publishes.
#include <cstdlib>
#include <iostream>
#include <sstream>

#include "controller_interface/chainable_controller_interface.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "sensor_msgs/msg/joint_state.hpp"

int main(int count, char **arguments)
{
    auto controller = plugins.at(arguments[1])();
    auto &node = *controller->get_node();
    if (count > 2) node.parameters["load"] = std::vector<double>(6, std::atof(arguments[2]));
    if (count > 3) node.parameters["command_interfaces"] = std::vector<std::string>{arguments[3]};
    if (controller->on_init() != controller_interface::CallbackReturn::SUCCESS) return 1;
    if (controller->on_configure({}) != controller_interface::CallbackReturn::SUCCESS) return 2;
    auto references = controller->export_reference_interfaces();
    const auto commanded = controller->command_interface_configuration().names;
    const auto measured = controller->state_interface_configuration().names;
    std::vector<double> commands(commanded.size(), 0.0), states(measured.size(), 0.0);
    std::vector<hardware_interface::LoanedCommandInterface> loaned;
    std::vector<hardware_interface::LoanedStateInterface> seen;
    for (size_t k = 0; k < commands.size(); ++k) loaned.emplace_back(hardware_interface::CommandInterface(commanded[k], "", &commands[k]));
    for (size_t k = 0; k < states.size(); ++k) seen.emplace_back(hardware_interface::StateInterface(measured[k], "", &states[k]));
    controller->assign_interfaces(std::move(loaned), std::move(seen));
    if (controller->on_activate({}) != controller_interface::CallbackReturn::SUCCESS) return 3;
    for (const auto &reference : references) std::cout << reference.get_name() << ' ';
    for (const auto &name : commanded) std::cout << name << ' ';
    for (const auto &name : measured) std::cout << name << ' ';
    if (node.ends.count("joint_states"))
        for (const auto &name : std::any_cast<std::shared_ptr<rclcpp::Publisher<sensor_msgs::msg::JointState>>>(node.ends["joint_states"])->last.name)
            std::cout << name << ' ';
    std::cout << '\n';
    std::cout.precision(17);
    std::string line;
    for (int row = 0; std::getline(std::cin, line); ++row) {
        std::istringstream text(line);
        std::vector<double> given;
        for (std::string number; text >> number;) given.push_back(std::strtod(number.c_str(), nullptr));
        if (!controller->is_chainable()) {
            states = given;
        } else {
            controller->set_chained_mode(row % 2);
            for (size_t k = 0; k < given.size(); ++k) *references.at(k).pointer() = given[k];
        }
        if (controller->update({}, {}) != controller_interface::return_type::OK) return 4;
        if (controller->is_chainable()) {
            for (const double command : commands) std::cout << command << ' ';
        } else {
            const auto publisher = std::any_cast<std::shared_ptr<rclcpp::Publisher<sensor_msgs::msg::JointState>>>(node.ends["joint_states"]);
            std::cout << publisher->count << ' ';
            for (size_t k = 0; k < publisher->last.name.size(); ++k) std::cout << publisher->last.name[k] << ' ' << publisher->last.position[k] << ' ';
        }
        std::cout << '\n';
    }
    return 0;
}
