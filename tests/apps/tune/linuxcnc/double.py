"""HAL in memory: the commands that `bristle tune` gives to halcmd, for tests without LinuxCNC."""

import re

from bristle.apps.tune.linuxcnc.hal import COMPUTED, HalError

PIN = re.compile(
    r"^(pin in|pin out|param rw|param r) (?:float|bit|u32|s32) (\w+)(?: = (\S+))?", re.MULTILINE
)
SAMPLER = (
    "".join(f"pin in float pin.{number}\n" for number in range(4))
    + "pin in bit enable = 1\npin out s32 curr-depth\n"
)
PID = (
    "pin out float output\npin in float command\npin in float feedback\nparam rw float Pgain = 12\n"
)
MODULES = {
    "pid": ("pid.0", PID),
    "rplant": ("rplant.0", "pin in float effort\npin out float position\n"),
    "streamer": ("streamer.0", "pin out float pin.0\npin in bit enable\n"),
    "sampler": ("sampler.0", SAMPLER),
}
DECLARED = re.compile(PIN.pattern.replace(r"\w", r"[\w.-]"), re.MULTILINE)
AXIS = (
    "loadrt streamer", "loadrt rplant", "loadrt pid", "addf streamer.0 servo", "addf pid.0.do-pid-calcs servo", "addf rplant.0 servo",
    "net ref streamer.0.pin.0 => pid.0.command", "net pos rplant.0.position => pid.0.feedback", "net eff pid.0.output => rplant.0.effort",
)  # fmt: skip


class Hal:
    """Components, pins, signals and functions of one thread; `installed` are the compiled components, by name."""

    def __init__(self, installed=None):
        self.installed = {} if installed is None else installed
        self.prefixes, self.loaded, self.values, self.ways, self.linked, self.order = (
            {},
            [],
            {},
            {},
            {},
            [],
        )
        self.run(*AXIS)

    def install(self, name, source):
        self.installed[name] = source

    def run(self, *lines, keep_going=False):
        for line in lines:
            command, *words = line.replace("=>", "").split()
            try:
                if command != "#":
                    getattr(self, command)(*words)
            except (KeyError, ValueError) as error:
                if not keep_going:
                    raise HalError(f"{line}: {error}") from None
        return []

    def loadrt(self, name, *options):
        if name in self.loaded:
            raise ValueError("duplicate component")
        prefix, source = (
            MODULES[name] if name in MODULES else (name.replace("_", "-"), self.installed[name])
        )
        prefix = next(
            (option.removeprefix("names=") for option in options if option.startswith("names=")),
            prefix,
        )
        if f"component {name} " not in source and name not in MODULES:
            raise ValueError("is another component")
        self.loaded.append(name)
        self.prefixes[name] = prefix
        for way, pin, value in DECLARED.findall(source.split("\n;;\n")[0]):
            self.values[f"{prefix}.{pin.replace('_', '-')}"] = float(value or 0)
            self.ways[f"{prefix}.{pin.replace('_', '-')}"] = way

    def unloadrt(self, name):
        self.loaded.remove(name)
        prefix = f"{self.prefixes[name]}."
        self.order = [function for function in self.order if not f"{function}.".startswith(prefix)]
        for pin in [pin for pin in self.values if pin.startswith(prefix)]:
            del self.values[pin], self.ways[pin]
            self.linked.pop(pin, None)

    def setp(self, pin, value):
        if (
            pin not in self.values
            or pin in self.linked
            or self.ways[pin] not in ("pin in", "param rw")
        ):
            raise ValueError("cannot be set")
        self.values[pin] = float(value)
        if pin == "bristle-guard.reset" and self.values[pin]:
            self.values["bristle-guard.ok"] = float(not self.values["bristle-guard.why"])

    def net(self, signal, *pins):
        for pin in pins:
            if pin not in self.values or self.linked.get(pin, signal) != signal:
                raise ValueError(f"{pin} cannot be linked")
            self.linked[pin] = signal

    def unlinkp(self, pin):
        del self.linked[pin]

    def delsig(self, signal):
        self.linked = {pin: own for pin, own in self.linked.items() if own != signal}

    def addf(self, function, _, place=None):
        if function in self.order:
            raise ValueError("duplicate function")
        if place is not None and int(place) > len(self.order) + 1:
            raise ValueError("no such place")
        self.order.insert(len(self.order) if place is None else int(place) - 1, function)

    def delf(self, function, _):
        self.order.remove(function)

    def get(self, *pins):
        if not set(pins) <= set(self.values):
            raise HalError("no such pin")
        return [self.values[pin] for pin in pins]

    def components(self):
        return sorted(self.loaded)

    def links(self):
        return {
            signal: sorted(pin for pin, own in self.linked.items() if own == signal)
            for signal in sorted(set(self.linked.values()))
        }

    def functions(self, _):
        return list(self.order)

    def value_of_parameters(self, components):
        prefixes = tuple(f"{component}." for component in components)
        return {
            pin: f"{value:.7g}"
            for pin, value in self.values.items()
            if pin.startswith(prefixes)
            and pin not in self.linked
            and self.ways[pin] in ("pin in", "param rw")
            and not pin.endswith(COMPUTED)
        }
