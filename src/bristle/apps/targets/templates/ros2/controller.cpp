/* {{ title }}, fed forward along the reference of joints: a chainable controller of ros2_control.

   {{ description }}
{% for line in facts %}   {{ line | folded('   ') }}
{% endfor %}   Written by bristle {{ version }}; do not edit, export again. */

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "controller_interface/chainable_controller_interface.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/joint_state.hpp"

#include "{{ name }}.h"

namespace {{ package }}
{
using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;
using hardware_interface::CommandInterface;

constexpr double MISSING = std::numeric_limits<double>::quiet_NaN();
const std::vector<std::string> KINDS = {"position", "velocity", "effort"}; // interfaces of each joint, in this order

/* The friction of a joint along its reference. */
struct Joint
{
    std::string name;
    double lead = 0.0;  /* by which the effort precedes the motion [s] */
    double limit = 0.0; /* largest size of the friction [{{ unit_force }}]; 0 for no limit */
    {{ name }} contact{};
{% if tuned %}    {{ name }}_parameters parameters{};
{% endif %}    double x = 0.0, v = 0.0, gain = 0.0;
    bool begun = false, fresh = false, placed = false;

    /* Begin with a virgin contact at a position. */
    void begin(double position)
    {
        {{ name }}_start(&contact);
{% if tuned %}        contact.parameters = parameters;
{% endif %}        (void){{ name }}_feed(&contact, position, 1.0);
        x = position;
        begun = fresh = true;
    }

    /* Return the friction of the step that ends at a reference, times the present gain, which follows `wish` by `slew`. */
    double fed(double position, double velocity, double dt, double wish, double slew)
    {
        const double now = gain;
        if (dt > 0.0) {
            const bool has_position = std::isfinite(position), has_velocity = std::isfinite(velocity);
            /* A contact on another reference, or with a fault, begins anew after its force has faded. */
            const bool known = (has_position || has_velocity) && (!begun || fresh || (placed == has_position && contact.flags == 0));
            if (known) {
                const double reached = has_position ? position : x + velocity * dt;
                if (!begun) {
                    begin(reached);
                }
                const double speed = has_velocity ? velocity : fresh ? 0.0 : (reached - x) / dt;
                const double change = fresh ? 0.0 : (speed - v) / dt;
                const double ahead = lead > 0.0 ? reached + (speed + 0.5 * change * lead) * lead : reached;
                (void){{ name }}_feed(&contact, ahead, dt);
                x = reached;
                v = speed;
                placed = has_position;
                fresh = false;
            } else if (gain == 0.0) {
                begun = false;
            }
            gain += std::clamp((known ? wish : 0.0) - gain, -slew * dt, slew * dt);
        }
        return limit > 0.0 ? std::clamp(now * contact.feed, -limit, limit) : now * contact.feed;
    }
};

class FrictionFeedforward : public controller_interface::ChainableControllerInterface
{
public:
    CallbackReturn on_init() override
    {
        (void)parameter("joints", std::vector<std::string>{}, "Joints with this friction");
        (void)parameter("command_interfaces", std::vector<std::string>{"effort"},
                        "Interfaces of each joint: effort, and position and velocity if the drive closes the loop");
        gain_ = parameter("gain", 0.0, "Share of the friction in the effort [1]", 0.0, 1.0);
        slew_ = parameter("slew", 1.0, "Largest change of the gain in a second [1/s]", 1e-3);
        timeout_ = parameter("reference_timeout", 0.1, "Time without a message after which there is no reference [s]", 0.0);
        changed_ = get_node()->add_on_set_parameters_callback([this](const std::vector<rclcpp::Parameter> & given) {
            for (const auto & each : given) {
                if (each.get_name() == "gain" || each.get_name() == "slew") {
                    (each.get_name() == "gain" ? gain_ : slew_) = each.as_double();
                }
            }
            rcl_interfaces::msg::SetParametersResult result;
            result.successful = true;
            return result;
        });
        return CallbackReturn::SUCCESS;
    }

    CallbackReturn on_configure(const rclcpp_lifecycle::State &) override
    {
        commanded_.clear();
        for (const auto & kind : get_node()->get_parameter("command_interfaces").get_value<std::vector<std::string>>()) {
            commanded_.push_back(static_cast<std::size_t>(std::find(KINDS.begin(), KINDS.end(), kind) - KINDS.begin()));
        }
        if (std::count(commanded_.begin(), commanded_.end(), 2u) != 1 || std::count(commanded_.begin(), commanded_.end(), KINDS.size())) {
            return refused("command_interfaces: must contain effort, and only position and velocity besides");
        }
        joints_.clear();
        for (const auto & name : get_node()->get_parameter("joints").get_value<std::vector<std::string>>()) {
            Joint joint;
            joint.name = name;
            joint.lead = parameter(name + ".lead", {{ lead }}, "Delay and lag of the drive, by which the effort precedes the motion [s]", 0.0, {{ lead_max }});
            joint.limit = parameter(name + ".limit", {{ limit }}, "Largest size of the friction [{{ unit_force }}]; 0 for no limit", 0.0);
{% if tuned %}            {{ name }}_start(&joint.contact);
            joint.parameters = joint.contact.parameters;
{% for each in tuned %}{% if each.size %}            {
                auto & values = joint.parameters.{{ each.field }};
                const auto given = parameter(name + ".friction.{{ each.name }}", std::vector<double>(values, values + {{ each.size }}), "{{ each.meaning }}");
                if (given.size() != {{ each.size }}) {
                    return refused(name + ".friction.{{ each.name }}: must have {{ each.size }} numbers");
                }
                std::copy(given.begin(), given.end(), values);
            }
{% else %}            joint.parameters.{{ each.field }} = parameter(name + ".friction.{{ each.name }}", joint.parameters.{{ each.field }}, "{{ each.meaning }}");
{% endif %}{% endfor %}            joint.begin(0.0);
            (void){{ name }}_feed(&joint.contact, 0.0, 1.0);
            if (joint.contact.flags != 0) {
                return refused(name + ".friction: a parameter is outside its range, see {{ name }}.h");
            }
{% endif %}            joints_.push_back(joint);
        }
        if (joints_.empty()) {
            return refused("joints: must name at least one joint");
        }
        reference_interfaces_.assign(KINDS.size() * joints_.size(), MISSING);
        listed_ = false;
        incoming_ = received_ = reference_interfaces_;
        subscription_ = get_node()->create_subscription<sensor_msgs::msg::JointState>(
            "~/reference", rclcpp::SystemDefaultsQoS(), [this](const sensor_msgs::msg::JointState::SharedPtr message) { receive(*message); });
        return CallbackReturn::SUCCESS;
    }

    CallbackReturn on_activate(const rclcpp_lifecycle::State &) override
    {
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            const double measured = state_interfaces_[j].get_optional().value_or(MISSING);
            joints_[j].gain = 0.0;
            joints_[j].begun = false;
            if (std::isfinite(measured)) {
                joints_[j].begin(measured);
            }
        }
        const std::lock_guard<std::mutex> lock(mutex_);
        arrived_ = false;
        std::fill(reference_interfaces_.begin(), reference_interfaces_.end(), MISSING);
        std::fill(received_.begin(), received_.end(), MISSING);
        return CallbackReturn::SUCCESS;
    }

    InterfaceConfiguration command_interface_configuration() const override
    {
        return claimed(commanded_);
    }

    InterfaceConfiguration state_interface_configuration() const override
    {
        return claimed({0});
    }

    /* Older versions of ros2_control call the first function, newer ones the second, versions between both. */
    std::vector<CommandInterface> on_export_reference_interfaces()
    {
        std::vector<CommandInterface> interfaces;
        interfaces.reserve(reference_interfaces_.size());
        for (std::size_t i = 0; i < reference_interfaces_.size(); ++i) {
            interfaces.push_back(reference(i));
        }
        listed_ = true;
        return interfaces;
    }

    std::vector<std::shared_ptr<CommandInterface>> on_export_reference_interfaces_list()
    {
        std::vector<std::shared_ptr<CommandInterface>> interfaces;
        for (std::size_t i = 0; i < reference_interfaces_.size() && !listed_; ++i) {
            interfaces.push_back(std::make_shared<CommandInterface>(reference(i)));
        }
        return interfaces;
    }

    return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration & period) override
    {
        age_ += period.seconds();
        if (mutex_.try_lock()) {
            if (arrived_) {
                std::copy(incoming_.begin(), incoming_.end(), received_.begin());
                arrived_ = false;
                age_ = 0.0;
            }
            mutex_.unlock();
        }
        if (timeout_ > 0.0 && age_ > timeout_) {
            std::fill(received_.begin(), received_.end(), MISSING);
        }
        std::copy(received_.begin(), received_.end(), reference_interfaces_.begin());
        return return_type::OK;
    }

    return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration & period) override
    {
        const double dt = period.seconds(), wish = gain_, slew = slew_;
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            const double *const given = &reference_interfaces_[KINDS.size() * j];
            const double friction = joints_[j].fed(given[0], given[1], dt, wish, slew);
            const double effort = std::isfinite(given[2]) ? given[2] + friction : friction;
            for (std::size_t c = 0; c < commanded_.size(); ++c) {
                (void)command_interfaces_[commanded_.size() * j + c].set_value(commanded_[c] == 2 ? effort : given[commanded_[c]]);
            }
        }
        return return_type::OK;
    }

private:
    template <typename T>
    T parameter(const std::string & name, const T & usual, const std::string & description, double least = MISSING, double most = MISSING)
    {
        if (!get_node()->has_parameter(name)) {
            rcl_interfaces::msg::ParameterDescriptor descriptor;
            descriptor.description = description;
            if (std::isfinite(least)) {
                descriptor.floating_point_range.resize(1);
                descriptor.floating_point_range[0].from_value = least;
                descriptor.floating_point_range[0].to_value = std::isfinite(most) ? most : std::numeric_limits<double>::max();
            }
            get_node()->template declare_parameter<T>(name, usual, descriptor);
        }
        return get_node()->get_parameter(name).template get_value<T>();
    }

    InterfaceConfiguration claimed(const std::vector<std::size_t> & kinds) const
    {
        InterfaceConfiguration made{controller_interface::interface_configuration_type::INDIVIDUAL, {}};
        for (const auto & joint : joints_) {
            for (const auto kind : kinds) {
                made.names.push_back(joint.name + "/" + KINDS[kind]);
            }
        }
        return made;
    }

    CallbackReturn refused(const std::string & reason)
    {
        RCLCPP_ERROR(get_node()->get_logger(), "%s", reason.c_str());
        return CallbackReturn::FAILURE;
    }

    CommandInterface reference(std::size_t i)
    {
        const std::string name = joints_[i / KINDS.size()].name + "/" + KINDS[i % KINDS.size()];
        return CommandInterface(get_node()->get_name(), name, &reference_interfaces_[i]);
    }

    void receive(const sensor_msgs::msg::JointState & message)
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        const std::vector<double> *const given[] = {&message.position, &message.velocity, &message.effort};
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            const auto at = static_cast<std::size_t>(std::find(message.name.begin(), message.name.end(), joints_[j].name) - message.name.begin());
            for (std::size_t k = 0; k < KINDS.size(); ++k) {
                incoming_[KINDS.size() * j + k] = at < message.name.size() && at < given[k]->size() ? (*given[k])[at] : MISSING;
            }
        }
        arrived_ = true;
    }

    std::vector<Joint> joints_;
    std::vector<std::size_t> commanded_; /* place of each commanded interface in KINDS */
    std::atomic<double> gain_{0.0}, slew_{1.0};
    double timeout_ = 0.0, age_ = 0.0;
    bool listed_ = false;
    std::mutex mutex_; /* of the two below; a control cycle never waits for it */
    std::vector<double> incoming_;
    bool arrived_ = false;
    std::vector<double> received_;
    rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr subscription_;
    rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr changed_;
};
} // namespace {{ package }}

PLUGINLIB_EXPORT_CLASS({{ package }}::FrictionFeedforward, controller_interface::ChainableControllerInterface)
