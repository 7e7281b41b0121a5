"""The files that `labrig init` starts a rig with."""

from labrig.config.templates.write import (
    NOT_CALIBRATED,
    template_path,
    template_text,
    write_templates,
)

__all__ = ["NOT_CALIBRATED", "template_path", "template_text", "write_templates"]
