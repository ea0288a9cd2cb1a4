/* Stand-ins for the parts of ROS 2 and ros2_control that an exported controller uses. They have the signatures of the headers of
   ros2_control 4 and rclcpp 28, and no middleware. */
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace rcl_interfaces::msg
{
struct FloatingPointRange
{
    double from_value = 0.0, to_value = 0.0, step = 0.0;
};
struct ParameterDescriptor
{
    std::string description;
    std::vector<FloatingPointRange> floating_point_range;
};
struct SetParametersResult
{
    bool successful = false;
    std::string reason;
};
} // namespace rcl_interfaces::msg

namespace sensor_msgs::msg
{
struct JointState
{
    using SharedPtr = std::shared_ptr<JointState>;
    std::vector<std::string> name;
    std::vector<double> position, velocity, effort;
};
} // namespace sensor_msgs::msg

namespace rclcpp
{
struct Time
{
};
struct Duration
{
    double length = 0.0;
    double seconds() const
    {
        return length;
    }
};
struct NodeOptions
{
};
struct SystemDefaultsQoS
{
};
struct Logger
{
};

using Value = std::variant<double, std::string, std::vector<double>, std::vector<std::string>>;

class Parameter
{
public:
    Parameter(std::string name, Value value) : name_(std::move(name)), value_(std::move(value))
    {
    }
    const std::string & get_name() const
    {
        return name_;
    }
    template <typename T> T get_value() const
    {
        return std::get<T>(value_);
    }
    double as_double() const
    {
        return get_value<double>();
    }

private:
    std::string name_;
    Value value_;
};

template <typename T> struct Subscription
{
    using SharedPtr = std::shared_ptr<Subscription>;
    std::function<void(std::shared_ptr<T>)> callback;
};

namespace node_interfaces
{
struct OnSetParametersCallbackHandle
{
    using SharedPtr = std::shared_ptr<OnSetParametersCallbackHandle>;
    std::function<rcl_interfaces::msg::SetParametersResult(const std::vector<Parameter> &)> callback;
};
} // namespace node_interfaces
} // namespace rclcpp

namespace rclcpp_lifecycle
{
struct State
{
};

class LifecycleNode
{
public:
    explicit LifecycleNode(std::string name) : name_(std::move(name))
    {
    }
    const char * get_name() const
    {
        return name_.c_str();
    }
    rclcpp::Logger get_logger() const
    {
        return {};
    }
    bool has_parameter(const std::string & name) const
    {
        return values.count(name) > 0;
    }
    template <typename T>
    T declare_parameter(const std::string & name, const T & usual, const rcl_interfaces::msg::ParameterDescriptor & descriptor)
    {
        if (descriptor.description.empty() || has_parameter(name)) {
            throw std::runtime_error(name + ": has no description, or is declared twice");
        }
        const auto given = overrides.find(name);
        values[name] = given == overrides.end() ? rclcpp::Value(usual) : given->second;
        ranges[name] = descriptor.floating_point_range;
        if (!allowed(name, values[name])) {
            throw std::runtime_error(name + ": is out of range");
        }
        return std::get<T>(values[name]);
    }
    rclcpp::Parameter get_parameter(const std::string & name) const
    {
        return {name, values.at(name)};
    }
    bool set_parameter(const rclcpp::Parameter & given)
    {
        const rclcpp::Value value = given.as_double();
        if (!allowed(given.get_name(), value) || !changed->callback({given}).successful) {
            return false;
        }
        values[given.get_name()] = value;
        return true;
    }
    template <typename F> rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(F && callback)
    {
        changed = std::make_shared<rclcpp::node_interfaces::OnSetParametersCallbackHandle>();
        changed->callback = callback;
        return changed;
    }
    template <typename T, typename F>
    typename rclcpp::Subscription<T>::SharedPtr create_subscription(const std::string &, const rclcpp::SystemDefaultsQoS &, F && callback)
    {
        auto made = std::make_shared<rclcpp::Subscription<T>>();
        made->callback = callback;
        publish = [made](const T & message) { made->callback(std::make_shared<T>(message)); };
        return made;
    }

    std::map<std::string, rclcpp::Value> overrides, values;
    std::map<std::string, std::vector<rcl_interfaces::msg::FloatingPointRange>> ranges;
    std::function<void(const sensor_msgs::msg::JointState &)> publish;
    rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr changed;

private:
    bool allowed(const std::string & name, const rclcpp::Value & value)
    {
        for (const auto & range : ranges[name]) {
            if (!(std::get<double>(value) >= range.from_value && std::get<double>(value) <= range.to_value)) {
                return false;
            }
        }
        return true;
    }
    std::string name_;
};

namespace node_interfaces
{
class LifecycleNodeInterface
{
public:
    enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };
    virtual ~LifecycleNodeInterface() = default;
    virtual CallbackReturn on_configure(const State &)
    {
        return CallbackReturn::SUCCESS;
    }
    virtual CallbackReturn on_activate(const State &)
    {
        return CallbackReturn::SUCCESS;
    }
};
} // namespace node_interfaces
} // namespace rclcpp_lifecycle

namespace hardware_interface
{
class Handle
{
public:
    Handle(const std::string & prefix, const std::string & interface, double * value) : name_(prefix + "/" + interface), value_(value)
    {
    }
    const std::string & get_name() const
    {
        return name_;
    }
    template <typename T = double> [[nodiscard]] std::optional<T> get_optional() const
    {
        return *value_;
    }
    template <typename T> [[nodiscard]] bool set_value(const T & value)
    {
        *value_ = value;
        return true;
    }

private:
    std::string name_;
    double * value_;
};
struct StateInterface : Handle
{
    using ConstSharedPtr = std::shared_ptr<const StateInterface>;
    using Handle::Handle;
};
struct CommandInterface : Handle
{
    using SharedPtr = std::shared_ptr<CommandInterface>;
    using Handle::Handle;
    CommandInterface(const CommandInterface &) = delete;
    CommandInterface(CommandInterface &&) = default;
};
class LoanedStateInterface
{
public:
    explicit LoanedStateInterface(StateInterface::ConstSharedPtr of) : of_(std::move(of))
    {
    }
    template <typename T = double> [[nodiscard]] std::optional<T> get_optional(unsigned int = 10) const
    {
        return of_->get_optional<T>();
    }

private:
    StateInterface::ConstSharedPtr of_;
};
class LoanedCommandInterface
{
public:
    LoanedCommandInterface(CommandInterface::SharedPtr of, std::function<void()> &&) : of_(std::move(of))
    {
    }
    template <typename T> [[nodiscard]] bool set_value(const T & value, unsigned int = 10)
    {
        return of_->set_value(value);
    }

private:
    CommandInterface::SharedPtr of_;
};
} // namespace hardware_interface

namespace controller_interface
{
using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;
enum class return_type : std::uint8_t { OK = 0, ERROR = 1 };
enum class interface_configuration_type : std::uint8_t { ALL = 0, INDIVIDUAL = 1, NONE = 2 };
struct InterfaceConfiguration
{
    interface_configuration_type type;
    std::vector<std::string> names = {};
};

class ChainableControllerInterface : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface
{
public:
    virtual InterfaceConfiguration command_interface_configuration() const = 0;
    virtual InterfaceConfiguration state_interface_configuration() const = 0;
    virtual CallbackReturn on_init() = 0;
    void assign_interfaces(std::vector<hardware_interface::LoanedCommandInterface> && commands,
                           std::vector<hardware_interface::LoanedStateInterface> && states)
    {
        command_interfaces_ = std::move(commands);
        state_interfaces_ = std::move(states);
    }
    return_type init(const std::string & name, const std::string &, unsigned int, const std::string &, const rclcpp::NodeOptions &)
    {
        node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>(name);
        return return_type::OK;
    }
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node()
    {
        return node_;
    }
    return_type update(const rclcpp::Time & time, const rclcpp::Duration & period)
    {
        if (!chained_) {
            (void)update_reference_from_subscribers(time, period);
        }
        return update_and_write_commands(time, period);
    }
    std::vector<hardware_interface::CommandInterface::SharedPtr> export_reference_interfaces()
    {
        std::vector<hardware_interface::CommandInterface::SharedPtr> made;
        for (auto & interface : on_export_reference_interfaces()) {
            made.push_back(std::make_shared<hardware_interface::CommandInterface>(std::move(interface)));
        }
        return made;
    }
    bool set_chained_mode(bool chained)
    {
        chained_ = chained;
        return true;
    }

protected:
    virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() = 0;
    virtual return_type update_reference_from_subscribers(const rclcpp::Time & time, const rclcpp::Duration & period) = 0;
    virtual return_type update_and_write_commands(const rclcpp::Time & time, const rclcpp::Duration & period) = 0;
    std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
    std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
    std::vector<double> reference_interfaces_;

private:
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_;
    bool chained_ = false;
};
} // namespace controller_interface

#define RCLCPP_ERROR(logger, ...) ((void)(logger), (void)std::fprintf(stderr, __VA_ARGS__))
#define PLUGINLIB_EXPORT_CLASS(controller, base) \
    static std::unique_ptr<base> made() \
    { \
        return std::make_unique<controller>(); \
    }
