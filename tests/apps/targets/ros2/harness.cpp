/* Runs an exported controller of the joints a and b over cycles: harness MODE DT MEASURED [NAME=VALUE ...].

   MODE is chained or topic; exit code 1 means that the controller refuses its parameters. Standard input has rows of six numbers: position, velocity and effort of a, and of b; a row of a
   topic whose first number is infinite sends no message. Standard output has the commands of each cycle, and at the end the
   allocations during all cycles. A parameter `@K:NAME=VALUE` is set before cycle K. */
#include CONTROLLER

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

static long allocations = 0;

__attribute__((noinline)) void * operator new(std::size_t size)
{
    ++allocations;
    if (void * const place = std::malloc(size)) {
        return place;
    }
    throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void * place) noexcept
{
    std::free(place);
}
__attribute__((noinline)) void operator delete(void * place, std::size_t) noexcept
{
    std::free(place);
}

static rclcpp::Value value_of(const std::string & text)
{
    if (text.find_first_not_of("0123456789+-.einf") == std::string::npos) {
        return std::strtod(text.c_str(), nullptr);
    }
    std::vector<std::string> words;
    std::vector<double> numbers;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        words.push_back(text.substr(at, end - at));
        numbers.push_back(std::strtod(words.back().c_str(), nullptr));
        at = end + 1;
    }
    return text.find_first_of("0123456789") == 0 ? rclcpp::Value(numbers) : rclcpp::Value(words);
}

int main(int count, char ** given)
{
    const std::string mode = given[1];
    const rclcpp::Duration period = DURATION(std::strtod(given[2], nullptr));
    double measured[] = {std::strtod(given[3], nullptr), 0.0};
    const auto controller = made();
    (void)controller->init("friction", "", 1000, "", rclcpp::NodeOptions());
    auto & node = *controller->get_node();
    node.overrides["joints"] = std::vector<std::string>{"a", "b"};
    std::map<long, std::vector<rclcpp::Parameter>> later;
    for (int i = 4; i < count; ++i) {
        const std::string text = given[i];
        const std::size_t colon = text[0] == '@' ? text.find(':') : 0, equal = text.find('=');
        const std::string name = text.substr(colon ? colon + 1 : 0, equal - (colon ? colon + 1 : 0));
        if (colon) {
            later[std::atol(text.c_str() + 1)].emplace_back(name, value_of(text.substr(equal + 1)));
        } else {
            node.overrides[name] = value_of(text.substr(equal + 1));
        }
    }
    const auto success = controller_interface::CallbackReturn::SUCCESS;
    const rclcpp_lifecycle::State state;
    if (controller->on_init() != success || controller->on_configure(state) != success) {
        return 1;
    }
    const auto references = controller->export_reference_interfaces();
    const auto names = controller->command_interface_configuration().names;
    if (references.size() != 6 || references[4]->get_name() != "friction/b/velocity") {
        return 2;
    }
    std::vector<double> commands(names.size());
    std::vector<hardware_interface::LoanedCommandInterface> loaned;
    std::vector<hardware_interface::LoanedStateInterface> states;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::size_t slash = names[i].find('/');
        loaned.emplace_back(std::make_shared<hardware_interface::CommandInterface>(names[i].substr(0, slash), names[i].substr(slash + 1), &commands[i]), nullptr);
    }
    for (std::size_t i = 0; i < 2; ++i) {
        states.emplace_back(std::make_shared<hardware_interface::StateInterface>(i ? "b" : "a", "position", &measured[i]));
    }
    controller->assign_interfaces(std::move(loaned), std::move(states));
    (void)controller->set_chained_mode(mode == "chained");
    if (controller->on_activate(state) != success) {
        return 3;
    }
    double row[6];
    long total = 0;
    for (long k = 0; std::fread(row, sizeof row, 1, stdin) == 1; ++k) {
        for (const auto & parameter : later[k]) {
            (void)node.set_parameter(parameter);
        }
        if (mode == "chained") {
            for (std::size_t i = 0; i < 6; ++i) {
                (void)references[i]->set_value(row[i]);
            }
        } else if (!std::isinf(row[0])) {
            sensor_msgs::msg::JointState message;
            message.name = {"b", "a"};
            message.position = {row[3], row[0]};
            message.velocity = {row[4], row[1]};
            message.effort = {row[5], row[2]};
            node.publish(message);
        }
        const long before = allocations;
        if (controller->update(TIME, period) != controller_interface::return_type::OK) {
            return 4;
        }
        total += allocations - before;
        std::fwrite(commands.data(), sizeof(double), commands.size(), stdout);
    }
    const double last = static_cast<double>(total);
    std::fwrite(&last, sizeof last, 1, stdout);
    return 0;
}
