"""Ground tools of a transformable CubeSat robot: upload, calibrate, record, decode, rehearse."""

__version__ = "0.1.0"
