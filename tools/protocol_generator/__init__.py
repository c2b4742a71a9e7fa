"""From protocol/tfsat.toml to every language that speaks the protocol."""
