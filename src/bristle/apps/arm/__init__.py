"""Arms: the joint efforts of a robot from its geometry, by the logs of all its joints."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.arm.identify import Arm, identify_arm, logs_of_joints

__getattr__ = loaded_from(__name__)
