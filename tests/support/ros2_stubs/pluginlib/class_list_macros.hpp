#pragma once
#include "controller_interface/controller_interface_base.hpp"

inline std::map<std::string, std::function<std::unique_ptr<controller_interface::ControllerInterfaceBase>()>> plugins;

#define PLUGIN_NAME_(line) plugin_##line
#define PLUGIN_(type, base, line) \
    static const bool PLUGIN_NAME_(line) = [] { \
        plugins[#type] = [] { return std::unique_ptr<base>(std::make_unique<type>()); }; return true; }();
#define PLUGIN_AT_(type, base, line) PLUGIN_(type, base, line)
#define PLUGINLIB_EXPORT_CLASS(type, base) PLUGIN_AT_(type, base, __LINE__)
