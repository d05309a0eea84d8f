"""From datasets to tables, figures, the report page and the headline."""
