"""LinuxCNC's HAL as a machine: streamer plays, sampler records, a guard component adds the feedforward."""

from bristle.tune.linuxcnc.machine import LinuxCNC

__all__ = ["LinuxCNC"]
