"""LinuxCNC's HAL as a machine: streamer plays, sampler records, a guard component adds the feedforward."""

from bristle.apps.tune.linuxcnc.machine import LinuxCNC

__all__ = ["LinuxCNC"]
