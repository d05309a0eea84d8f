"""From datasets to tables, figures, the report page and the headline."""

from vibrom.artefacts.extras import need

need("matplotlib", "the report", "workflow")
