# Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
meta:
  id: tfsat_log
  title: tfsat drop log
  endian: le
  license: MIT
doc: |
  A row of 512-byte blocks. Kaitai does not check the CRC: see `crc` of each block
  (CRC-32/ISO-HDLC over the bytes before it). A block that was never written is all zero.
seq:
  - id: blocks
    type: block
    size: 512
    repeat: eos
types:
  block:
    seq:
      - id: head
        type: block_header
      - id: body
        size: 476
        type:
          switch-on: head.kind
          cases:
            'block_kind::header': log_header
            'block_kind::data': data
            'block_kind::footer': log_footer
      - id: crc
        type: u4
  data:
    seq:
      - id: sample_slots
        type: sample
        repeat: expr
        repeat-expr: 6
      - id: event_slots
        type: event
        repeat: expr
        repeat-expr: 2
  imu_reading:
    doc: 'One 14-byte burst of an MPU-6050, registers 0x3B to 0x48 (RM-MPU-6000A rev. 4.2, p. 29-32), raw counts.'
    seq:
      - id: accel
        type: s2
        repeat: expr
        repeat-expr: 3
        doc: 'Specific force x, y, z.'
      - id: temperature
        type: s2
        doc: 'Die temperature: counts / temperature_lsb_per_c + temperature_offset_c.'
      - id: gyro
        type: s2
        repeat: expr
        repeat-expr: 3
        doc: 'Angular rate x, y, z.'
  sample:
    doc: 'All sensors, each read at the sample''s time and its offset in LogHeader.'
    seq:
      - id: time_offset_us
        type: u4
        doc: 'Time after the block''s time_us.'
      - id: flags
        type: u2
        doc: 'Bits 0-3: IMU 1-4 valid; 4-9: angle sensor 1-6 valid; 10, 11: release switch 1, 2 open; 12-15: IMU 1-4 clipped.'
      - id: imu
        type: imu_reading
        repeat: expr
        repeat-expr: 4
        doc: 'Bodies 1 to 4.'
      - id: angle
        type: u2
        repeat: expr
        repeat-expr: 6
        doc: 'Absolute angle sensors, ADC counts: joint 1 (two sensors), joint 2, joint 3.'
  event:
    doc: 'Something that happened, with its own time.'
    seq:
      - id: time_us
        type: u8
        doc: 'The logger''s clock, since power-up.'
      - id: code
        type: u1
        enum: event_code
        doc: 'What happened.'
      - id: index
        type: u1
        doc: 'Which one; see EventCode.'
      - id: arg
        type: u2
        doc: 'See EventCode.'
      - id: value
        type: s4
        doc: 'See EventCode.'
  servo_setting:
    doc: 'How a joint''s servo turns pulses into angles, and how far it may go.'
    seq:
      - id: zero_us
        type: u2
        doc: 'Pulse width that holds 0 deg.'
      - id: ns_per_deg
        type: u2
        doc: 'Change of pulse width for each degree.'
      - id: reversed
        type: u1
        doc: '1: shorter pulses open the joint.'
      - id: min_cdeg
        type: s2
        doc: 'Least angle that may be commanded.'
      - id: max_cdeg
        type: s2
        doc: 'Greatest angle that may be commanded.'
  block_header:
    doc: 'The first 32 bytes of every block.'
    seq:
      - id: magic
        type: u4
        doc: 'block_magic.'
      - id: version
        type: u1
        doc: 'block_version.'
      - id: kind
        type: u1
        enum: block_kind
        doc: 'What the block holds.'
      - id: sample_count
        type: u1
        doc: 'Sample slots in use.'
      - id: event_count
        type: u1
        doc: 'Event slots in use.'
      - id: session
        type: u4
        doc: 'Random id of the recording.'
      - id: block_number
        type: u4
        doc: 'From 0, without gaps in a recording.'
      - id: first_sample
        type: u4
        doc: 'Index of the block''s first sample in the recording, counting dropped ones too.'
      - id: samples_dropped
        type: u4
        doc: 'Samples lost so far because the ring was full.'
      - id: time_us
        type: u8
        doc: 'The logger''s clock at the block''s first sample, since power-up.'
  log_header:
    doc: 'What was recorded, with which scales. Payload of a header block.'
    seq:
      - id: protocol_hash
        type: u1
        repeat: expr
        repeat-expr: 8
        doc: 'Of the specification that the firmware was built with.'
      - id: firmware_version
        type: u1
        repeat: expr
        repeat-expr: 3
        doc: 'Major, minor, patch.'
      - id: imu_present
        type: u1
        doc: 'Bits 0-3: IMU 1-4 answered at the start.'
      - id: board_serial
        type: u1
        repeat: expr
        repeat-expr: 8
        doc: 'The logger''s serial number.'
      - id: image_crc
        type: u4
        doc: 'CRC-32/ISO-HDLC of the flashed image.'
      - id: rate_hz
        type: f4
        doc: 'Commanded sampling rate.'
      - id: gyro_lsb_per_deg_s
        type: f4
        doc: 'Gyro scale.'
      - id: accel_lsb_per_g
        type: f4
        doc: 'Accelerometer scale.'
      - id: temperature_lsb_per_c
        type: f4
        doc: 'Temperature scale of an MPU-6050; of the other parts see IMUs.'
      - id: temperature_offset_c
        type: f4
        doc: 'Temperature of an MPU-6050 at zero counts.'
      - id: angle_counts_per_turn
        type: u4
        doc: 'ADC counts of a full turn of an angle sensor.'
      - id: gyro_range_deg_s
        type: u2
        doc: 'Full scale, +-.'
      - id: accel_range_g
        type: u1
        doc: 'Full scale, +-.'
      - id: dlpf_cfg
        type: u1
        doc: 'Low-pass of the IMUs, CONFIG.DLPF_CFG; see IMUs.'
      - id: who_am_i
        type: u1
        repeat: expr
        repeat-expr: 4
        doc: 'Register 0x75 of each IMU; 0 where none answered.'
      - id: bus_khz
        type: u2
        doc: 'Clock of the I2C buses.'
      - id: after_landing_s
        type: u2
        doc: 'The recording closes by itself this long after the landing.'
      - id: schema
        type: u1
        repeat: expr
        repeat-expr: 384
        doc: 'This layout in words, ASCII, padded with zeros: a file found in ten years explains itself.'
      - id: wall_clock_us
        type: u8
        doc: 'Unix time at time_us, if the host set the clock; else 0.'
      - id: imu_offset_us
        type: u2
        repeat: expr
        repeat-expr: 4
        doc: 'From a sample''s time to the moment of each IMU''s reading. 0 in logs of block_version 2, which do not tell it.'
      - id: angle_offset_us
        type: u2
        repeat: expr
        repeat-expr: 6
        doc: 'The same of each angle sensor.'
      - id: maneuver_known
        type: u1
        doc: '1: the next field is known. 0 also in logs of firmware that does not tell it.'
      - id: maneuver_crc
        type: u2
        doc: 'Of the maneuver that the sequencer held when the recording was started, as in maneuver_info.'
  log_footer:
    doc: 'Summary written when a recording is closed cleanly. Payload of a footer block.'
    seq:
      - id: samples
        type: u4
        doc: 'Samples taken, dropped ones included.'
      - id: samples_dropped
        type: u4
        doc: 'Samples lost because the ring was full.'
      - id: blocks
        type: u4
        doc: 'Blocks of the recording, this one included.'
      - id: ring_peak_blocks
        type: u4
        doc: 'Most blocks that ever waited for the card.'
      - id: interval_min_us
        type: u4
        doc: 'Shortest time between two samples.'
      - id: interval_max_us
        type: u4
        doc: 'Longest time between two samples.'
      - id: jitter_rms_us
        type: f4
        doc: 'Root mean square of how far the times between samples were from the nominal one.'
      - id: late_ticks
        type: u4
        doc: 'Times between samples over one and a half nominal ones: ticks without a sample.'
      - id: ring_blocks
        type: u4
        doc: 'Blocks that the ring can hold.'
      - id: card_stall_max_ms
        type: u4
        doc: 'Longest time that the card took nothing.'
      - id: blocks_rewritten
        type: u4
        doc: 'Blocks that were written a second time after the landing.'
      - id: stop_reason
        type: u1
        enum: stop_reason
        doc: 'Why the recording ended.'
  logger_settings:
    doc: 'How the logger samples and records.'
    seq:
      - id: rate_hz
        type: u2
        doc: 'Sampling rate.'
      - id: gyro_range_deg_s
        type: u2
        doc: 'Full scale, +-: 250, 500, 1000 or 2000.'
      - id: accel_range_g
        type: u1
        doc: 'Full scale, +-: 2, 4, 8 or 16.'
      - id: dlpf_cfg
        type: u1
        doc: 'Low-pass of the IMUs, CONFIG.DLPF_CFG, 0 to 6: 256, 188, 98, 42, 20, 10, 5 Hz.'
      - id: bus_khz
        type: u2
        doc: 'Clock of the I2C buses: 100 or 400.'
      - id: after_landing_s
        type: u2
        doc: 'A recording closes by itself this long after the landing.'
      - id: file_mib
        type: u2
        doc: 'Room that a recording takes on the card.'
  log_entry:
    doc: 'A recording that the logger can hand over.'
    seq:
      - id: number
        type: u2
        doc: 'Of its file, DROP0001.BIN and up; 0 is what RAM holds.'
      - id: session
        type: u4
        doc: 'Random id of the recording; 0: its first block says nothing.'
      - id: blocks
        type: u4
        doc: 'Blocks of the file; unused room included where it was not closed.'
      - id: wall_clock_us
        type: u8
        doc: 'Unix time of its start, or 0.'
      - id: closed
        type: u1
        doc: '1: its last block is its footer.'
enums:
  stop_reason:
    1:
      id: host
      doc: 'A host asked for it.'
    2:
      id: landing
      doc: 'The time after the landing was over.'
    3:
      id: file_full
      doc: 'The file had no more room; before a release the recording goes on in the next.'
    4:
      id: card_gone
      doc: 'The card took nothing, and more samples would have cost RAM the drop.'
  block_kind:
    1:
      id: header
      doc: 'LogHeader: what was recorded, with which scales.'
    2:
      id: data
      doc: 'Samples and events.'
    3:
      id: footer
      doc: 'LogFooter: the recording was closed cleanly.'
  event_code:
    1:
      id: switch_edge
      doc: 'A release switch changed: index = switch, arg = 1 opened, 0 closed, value = edges before it that came too fast to keep.'
    2:
      id: stroke
      doc: 'The sequencer''s stroke line rose: index = count since the recording began, from 0, value = edges before it that came too fast to keep.'
    3:
      id: sensor_fault
      doc: 'A sensor gives no readings any more, or for another reason than before: index = IMU, arg = error code; sensor_foreign: value = its WHO_AM_I; else value = microseconds before the event from which its readings are in doubt, 0: none. They repeat (sensor_frozen), or may be in other scales: a part that wakes up measuring had not shown its settings since, whatever it failed of in the end.'
    4:
      id: sensor_recovered
      doc: 'A sensor answers again: index = IMU, value = its WHO_AM_I, 0 in logs of earlier firmware.'
    5:
      id: card_stall
      doc: 'A card write took long: value = milliseconds.'
    6:
      id: samples_dropped
      doc: 'The ring was full: value = samples lost.'
    7:
      id: release
      doc: 'The logger detected a release, see [release]; time = its t = 0, arg = 1. arg = 0: a false release, both switches closed again.'
    8:
      id: landing
      doc: 'The robot has landed: arg = 1 by a shock, value = mg; arg = 0 by the time since the release.'
    9:
      id: ring_high_water
      doc: 'More of the ring than ever waits for the card: arg = quarters of the ring, value = blocks.'
    10:
      id: card_lost
      doc: 'The card stopped answering: arg = error code. It is tried again for as long as the ring has room.'
    11:
      id: card_back
      doc: 'The card takes blocks again: value = milliseconds that it was gone.'
    12:
      id: rewritten
      doc: 'The last seconds were written a second time: value = blocks.'
    13:
      id: sampling_late
      doc: 'Ticks of the sampling timer passed without a sample: value = microseconds since the sample before.'
    15:
      id: sensor_missed
      doc: 'A transfer from a running IMU failed; its reading is missing until it has shown that it kept its settings, most often this one only: index = IMU, arg = error code. One that stays away for 20 ms is a sensor_fault.'
