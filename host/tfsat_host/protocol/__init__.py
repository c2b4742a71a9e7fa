"""The protocol of tfsat: messages, frames, enumerations, limits, log layout.

Most modules here are generated from ``protocol/tfsat.toml``; `record`, `framing` and
`log_layout` are written by hand. See ``protocol/reference.md``.
"""
