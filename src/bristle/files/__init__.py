"""Files of the user and results of bristle: axes, models and experiments in TOML."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.files.arguments import (
        AXIS,
        EXPERIMENT,
        axes_for,
        log_and_axis,
        logs_and_axes,
        read_log,
    )
    from bristle.files.arrays import read_arrays, write_arrays
    from bristle.files.axis import axis_text, describes_curves, read_axis
    from bristle.files.axis_form import CHANNELS, EMPTY, edited, form_of, with_columns_of_motion
    from bristle.files.components import (
        FILL_IN,
        check_keys,
        check_schema,
        key_of,
        name_of,
        number_at,
        table_at,
    )
    from bristle.files.curves import read_curves
    from bristle.files.experiment import (
        Planned,
        experiment_from,
        planned_in,
        read_experiment,
        with_models,
    )
    from bristle.files.experiment_text import LOOP, NextExperiment
    from bristle.files.growing import Growing, growing_folder, verified
    from bristle.files.inspection import Inspection
    from bristle.files.joints import axes_in, joints_in
    from bristle.files.machine import MachineFile, read_machine
    from bristle.files.model import FITTED_TO, TREATMENT, read_model, write_model
    from bristle.files.motion import log_text
    from bristle.files.operator import holds_operator, read_operator, write_operator
    from bristle.files.owned import NOTE, lock
    from bristle.files.permission import CODE_LIMIT, allow, code_at, code_named, state_folder
    from bristle.files.proposal import Proposal, propose_axis
    from bristle.files.results import SUMMARY, Results, results_folder
    from bristle.files.single import write_whole
    from bristle.files.sources import Sources
    from bristle.files.summary import as_json, plain, provenance
    from bristle.files.toml import TOML_LIMIT, Said, as_toml, read_toml
    from bristle.files.user_model import (
        SourceText,
        codes_of,
        declared_in,
        friction_named,
        load_checked,
        load_code,
        load_reader_file,
        load_slot_file,
        origins_of_code,
        word_of,
    )
    from bristle.files.variant import variables_of_section
    from bristle.files.varied import with_changes, with_columns

__getattr__ = loaded_from(__name__)
