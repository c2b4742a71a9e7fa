"""Files in TOML that people write: one reader whose errors name file, line and cure, and one writer."""

from tfsat_host.config.table import ConfigKind, Fault, Table
from tfsat_host.config.toml import format_config, parse_config, read_config, with_entry

__all__ = ["ConfigKind", "Fault", "Table", "format_config", "parse_config", "read_config", "with_entry"]
