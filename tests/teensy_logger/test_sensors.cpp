// What the sensors say reaches the sample in the right scale and with the right flags, at every
// range; what is no part that it knows does not.
#include "sensor_bench.h"

using namespace tfsat;
using tfsat_test::kG_m_s2;
using tfsat_test::kRad;
using tfsat_test::SensorBench;
using protocol::ErrorCode;
using protocol::EventCode;

TEST_CASE(all_sensors_come_up_with_the_paper_s_range) {
  SensorBench bench;
  bench.run_ms(300);
  CHECK(bench.sampler.imu_present() == 0x0F);
  CHECK((bench.instant.sample.flags & 0xF3FF) == 0x03FF);
  for (int i = 0; i < 4; ++i) {
    const protocol::ImuReading& reading = bench.instant.sample.imu[i];
    CHECK_NEAR(reading.gyro[0] / 65.5, kRad, 0.05);
    CHECK_NEAR(reading.gyro[1] / 65.5, 0.1 * kRad * i, 0.05);
    CHECK_NEAR(reading.accel[2] / 2048.0, 1.0, 0.001);
    CHECK_NEAR(reading.temperature / 340.0 + 36.53, 25.0, 0.06);
  }
  for (uint16_t i = 0; i < 6; ++i) CHECK(bench.instant.sample.angle[i] == 1000 + i);
  uint8_t who_am_i[4];
  bench.sampler.copy_who_am_i(who_am_i);
  for (const uint8_t id : who_am_i) CHECK(id == 0x68);
  CHECK(bench.events.size() == 4);
  for (const protocol::Event& event : bench.events) {
    CHECK(event.code == EventCode::kSensorRecovered && event.arg == 0 && event.value == 0x68);
  }
}

TEST_CASE(switches_and_angles_carry_their_flags) {
  SensorBench bench;
  bench.switches.open = 0x02;
  bench.angles.converted = 0x3E;
  bench.run_ms(10);
  CHECK((bench.instant.sample.flags & 0x0C00) == 0x0800);
  CHECK((bench.instant.sample.flags & 0x03F0) == 0x03E0);
  CHECK(bench.instant.sample.angle[0] == 0 && bench.instant.sample.angle[1] == 1001);
}

TEST_CASE(every_range_has_its_scale_and_flags_what_leaves_it) {
  const uint16_t gyro_ranges[] = {250, 500, 1000, 2000};
  const uint8_t accel_ranges[] = {2, 4, 8, 16};
  SensorBench bench;
  for (int g = 0; g < 4; ++g) {
    for (int a = 0; a < 4; ++a) {
      protocol::LoggerSettings settings = logger::factory_settings();
      settings.gyro_range_deg_s = gyro_ranges[g];
      settings.accel_range_g = accel_ranges[a];
      bench.apply(settings);
      bench.rate_rad_s = 0.99 * gyro_ranges[g] / kRad;
      bench.force_m_s2 = 0.99 * accel_ranges[a] * kG_m_s2;
      bench.run_ms(300);
      CHECK(bench.sampler.imu_present() == 0x0F);
      CHECK((bench.instant.sample.flags & 0xF00F) == 0x000F);
      const protocol::ImuReading& reading = bench.instant.sample.imu[3];
      const double gyro_deg_s = reading.gyro[0] / logger::gyro_lsb_per_deg_s(settings);
      const double accel_g = reading.accel[2] / logger::accel_lsb_per_g(settings);
      CHECK_NEAR(gyro_deg_s, 0.99 * gyro_ranges[g], 0.001 * gyro_ranges[g]);
      CHECK_NEAR(accel_g, 0.99 * accel_ranges[a], 0.001 * accel_ranges[a]);
      bench.rate_rad_s = -1.01 * gyro_ranges[g] / kRad;
      bench.run_ms(100);
      CHECK((bench.instant.sample.flags & 0xF00F) == 0xF00F);
      CHECK(bench.instant.sample.imu[0].gyro[0] == -32768);
      bench.rate_rad_s = 0.0;
      bench.run_ms(100);
      CHECK((bench.instant.sample.flags & 0xF00F) == 0x000F);
      bench.force_m_s2 = 1.01 * accel_ranges[a] * kG_m_s2;
      bench.run_ms(100);
      CHECK((bench.instant.sample.flags & 0xF00F) == 0xF00F);
      CHECK(bench.instant.sample.imu[0].accel[2] == 32767);
    }
  }
}

TEST_CASE(the_filter_is_the_one_that_was_set) {
  for (const uint8_t dlpf : {uint8_t{0}, uint8_t{3}, uint8_t{6}}) {
    SensorBench bench;
    protocol::LoggerSettings settings = logger::factory_settings();
    settings.dlpf_cfg = dlpf;
    bench.apply(settings);
    bench.run_ms(300);
    uint8_t config = 0xFF;
    CHECK(bench.imu(2).read(emulator::mpu6050::kConfig, &config, 1) && config == dlpf);
  }
}

TEST_CASE(nothing_is_read_before_settings_are_applied) {
  SensorBench bench;
  logger::Sampler idle(bench.port_a, bench.port_b, bench.angles, bench.switches);
  logger::Instant instant;
  idle.sample(5000, instant);
  CHECK(bench.port_a.transfers == 0 && bench.port_b.transfers == 0);
  CHECK((instant.sample.flags & 0x03FF) == 0x03F0 && instant.event_count == 0);
}

TEST_CASE(a_sensor_that_restarted_is_configured_anew) {
  SensorBench bench;
  bench.run_ms(300);
  bench.events.clear();
  bench.imu(2).power_up(bench.t_us);
  bench.tick();
  CHECK(!bench.valid(2) && bench.instant.sample.imu[2].accel[2] == 0);
  CHECK(bench.lost_by_others(300, 2) == 0);
  CHECK(bench.valid(2));
  CHECK_NEAR(bench.instant.sample.imu[2].gyro[0] / 65.5, kRad, 0.05);
  CHECK(bench.events.size() == 2);
}

// The parts that are sold as MPU-6050, mixed as they come: their own filters are set, and their
// readings have the same scales.
TEST_CASE(register_compatible_parts_are_taken_as_they_are) {
  const uint8_t parts[][4] = {{0x70, 0x71, 0x73, 0x98}, {0x68, 0x98, 0x68, 0x70}, {0x98, 0x98, 0x98, 0x98}};
  for (const auto& fitted : parts) {
    SensorBench bench;
    for (int i = 0; i < 4; ++i) bench.imu(i).replace(fitted[i], 0);
    bench.run_ms(300);
    CHECK(bench.sampler.imu_present() == 0x0F);
    uint8_t who_am_i[4];
    bench.sampler.copy_who_am_i(who_am_i);
    for (int i = 0; i < 4; ++i) {
      CHECK(who_am_i[i] == fitted[i]);
      CHECK_NEAR(bench.instant.sample.imu[i].gyro[0] / 65.5, kRad, 0.05);
      CHECK_NEAR(bench.instant.sample.imu[i].accel[2] / 2048.0, 1.0, 0.001);
      uint8_t filter = 0xFF;
      CHECK(bench.imu(i).read(emulator::mpu6050::kAccelConfig2, &filter, 1));
      CHECK(filter == (fitted[i] == 0x68 ? 0 : 3));
    }
  }
}

// A part that wakes up measuring goes on at 250 deg/s and 2 g, and misses no transfer. Within
// kProofEveryUs and one more instant it is found, and the event says which readings it spoils.
TEST_CASE(a_part_that_lost_its_settings_in_silence_is_found) {
  for (const uint16_t rate_hz : {uint16_t{280}, uint16_t{1000}, uint16_t{50}}) {
    for (int imu = 0; imu < 4; ++imu) {
      protocol::LoggerSettings settings = logger::factory_settings();
      settings.rate_hz = rate_hz;
      SensorBench bench(settings);
      for (int i = 0; i < 4; ++i) bench.imu(i).replace(0x70, 0);
      bench.run_ms(300 + 17 * static_cast<uint32_t>(imu));
      bench.events.clear();
      const uint64_t lost_us = bench.t_us;
      bench.imu(imu).power_up(lost_us);
      bench.move_to(lost_us + 40000);  // its start-up, between two readings
      bench.ticks += 40u * rate_hz / 1000u;
      for (int i = 0; i < rate_hz && bench.events.empty(); ++i) bench.tick();
      CHECK(!bench.events.empty());
      if (bench.events.empty()) continue;
      const protocol::Event& event = bench.events[0];
      CHECK(event.code == EventCode::kSensorFault && event.index == imu);
      CHECK(event.arg == static_cast<uint16_t>(ErrorCode::kSensorReset));
      CHECK(event.time_us - lost_us <= 40000 + logger::Mpu6050::kProofEveryUs + 2 * bench.period_us());
      const uint64_t suspect_from_us = event.time_us - static_cast<uint64_t>(event.value);
      CHECK(event.value == 0 || suspect_from_us <= lost_us + 1);
      CHECK(event.value <= static_cast<int32_t>(logger::Mpu6050::kProofEveryUs + 40000 + 2 * bench.period_us()));
      CHECK(!bench.valid(imu));
      bench.run_ms(300);
      CHECK(bench.valid(imu));
      CHECK_NEAR(bench.instant.sample.imu[imu].gyro[0] / 65.5, kRad, 0.05);
    }
  }
}

// It loses its settings in silence, goes on in other scales, and then fails for another reason before
// it has shown them again: its event reaches back to when it last did. What sleeps after a reset said
// zeros instead; and where the settings are what a reset leaves, nothing was lost.
TEST_CASE(a_fault_after_a_silent_loss_tells_since_when_settings_were_not_seen) {
  const ErrorCode errors[] = {ErrorCode::kSensorMissing, ErrorCode::kBusStuck, ErrorCode::kSensorFrozen};
  for (const ErrorCode error : errors) {
    for (const uint8_t part : {uint8_t{0x70}, uint8_t{0x71}, uint8_t{0x73}, uint8_t{0x98}, uint8_t{0x68}}) {
      for (const bool as_reset : {false, true}) {
        protocol::LoggerSettings settings = logger::factory_settings();
        if (as_reset) settings.dlpf_cfg = 0, settings.gyro_range_deg_s = 250, settings.accel_range_g = 2;
        SensorBench bench(settings);
        const int imu = 1;
        bench.imu(imu).replace(part, 0);
        bench.run_ms(300);
        for (const int proofs = bench.port_a.proofs; !as_reset && bench.port_a.proofs < proofs + 2;) bench.tick();
        bench.events.clear();
        const uint64_t proven_us = bench.t_us;
        const bool wakes_measuring = part == 0x70 || part == 0x71 || part == 0x73;
        const bool frozen = error == ErrorCode::kSensorFrozen;
        if (wakes_measuring && !frozen) {
          bench.imu(imu).power_up(bench.t_us);
          bench.move_to(bench.t_us + 40000);  // its start-up, between two readings
          bench.ticks += 40u * settings.rate_hz / 1000u;
        }
        if (!frozen) bench.run_ms(30);
        if (error == ErrorCode::kSensorMissing) bench.imu(imu).set_fault(emulator::Mpu6050Fault::kDead);
        if (error == ErrorCode::kBusStuck) bench.buses[0].set_hanging(SensorBench::address(imu), true);
        if (frozen) bench.imu(imu).set_fault(emulator::Mpu6050Fault::kFrozen);
        for (int i = 0; i < 60; ++i) {
          bench.tick();
          if (!bench.events.empty() && bench.events.back().code == EventCode::kSensorFault) break;
        }
        CHECK(!bench.events.empty());
        if (bench.events.empty()) continue;
        const protocol::Event& event = bench.events.back();
        CHECK(event.code == EventCode::kSensorFault && event.index == imu);
        CHECK(event.arg == static_cast<uint16_t>(error));
        const uint64_t reaches_to_us = event.time_us - static_cast<uint64_t>(event.value);
        if (frozen) {
          CHECK(event.value >= static_cast<int32_t>(protocol::kFrozenUs));
        } else if (part == 0x68 || as_reset) {
          CHECK(event.value == 0);
        } else {
          CHECK(reaches_to_us > proven_us - 2 * bench.period_us() && reaches_to_us <= proven_us + 1);
        }
      }
    }
  }
}

// Where the settings are what a reset leaves, there is nothing to lose, and nothing to ask for.
TEST_CASE(a_proof_costs_no_reading_and_none_is_asked_for_in_vain) {
  for (const uint16_t bus_khz : {uint16_t{400}, uint16_t{100}}) {
    protocol::LoggerSettings settings = logger::factory_settings();
    settings.bus_khz = bus_khz;
    settings.rate_hz = logger::max_rate_hz(bus_khz);
    for (const bool as_reset : {false, true}) {
      if (as_reset) settings.dlpf_cfg = 0, settings.gyro_range_deg_s = 250, settings.accel_range_g = 2;
      SensorBench bench(settings);
      bench.run_ms(300);
      bench.events.clear();
      const int before = bench.port_a.transfers;
      const uint64_t from = bench.ticks;
      CHECK(bench.lost_by_others(2000, -1) == 0 && bench.events.empty());
      CHECK(bench.longest_us < bench.period_us());
      const int proofs = bench.port_a.transfers - before - 2 * static_cast<int>(bench.ticks - from);
      CHECK(as_reset ? proofs == 0 : proofs >= 36 && proofs <= 40);
    }
  }
}

TEST_CASE(what_comes_in_the_place_of_another_part_tells_who_it_is) {
  SensorBench bench;
  bench.run_ms(300);
  bench.events.clear();
  bench.imu(2).replace(0x98, bench.t_us);
  bench.run_ms(300);
  CHECK(bench.valid(2) && bench.events.size() == 2);
  const protocol::Event& event = bench.events.back();
  CHECK(event.code == EventCode::kSensorRecovered && event.index == 2 && event.value == 0x98);
}

TEST_CASE(another_chip_is_not_believed_and_its_id_is_told) {
  SensorBench bench;
  bench.imu(1).replace(0x12, 0);
  bench.run_ms(300);
  CHECK(bench.sampler.imu_present() == 0x0D && !bench.valid(1));
  uint8_t who_am_i[4];
  bench.sampler.copy_who_am_i(who_am_i);
  CHECK(who_am_i[1] == 0x12 && who_am_i[0] == 0x68);
  int told = 0;
  for (const protocol::Event& event : bench.events) {
    if (event.code != EventCode::kSensorFault) continue;
    ++told;
    CHECK(event.index == 1 && event.arg == static_cast<uint16_t>(ErrorCode::kSensorForeign));
  }
  CHECK(told == 1);
}

// With all six axes at the ends of their ranges no noise is to be seen, and the temperature alone
// is no witness. With one axis inside its range, there is.
TEST_CASE(a_long_hard_landing_is_clipped_and_not_frozen) {
  emulator::Mpu6050Parameters silent;
  silent.temperature_noise_c = 0.0;
  for (const bool all_axes : {true, false}) {
    SensorBench bench(logger::factory_settings(), silent);
    bench.run_ms(160);
    CHECK(bench.sampler.imu_present() == 0x0F);
    bench.events.clear();
    bench.lateral_m_s2 = bench.force_m_s2 = 40.0 * kG_m_s2;
    bench.lateral_rad_s = -40.0;
    bench.rate_rad_s = all_axes ? 40.0 : 1.0;
    bench.run_ms(99);
    CHECK((bench.instant.sample.flags & 0xF00F) == 0xF00F);
    bench.run_ms(300);
    CHECK(bench.events.empty() == all_axes);
    if (all_axes) CHECK((bench.instant.sample.flags & 0xF00F) == 0xF00F);
  }
}

// The first IMU of a bus is gone: the second is read when the header says all the same, in all
// instants but those in which the first is looked for.
TEST_CASE(the_second_imu_keeps_its_offset_without_the_first) {
  for (const uint16_t bus_khz : {uint16_t{400}, uint16_t{100}}) {
    for (const bool fastest : {false, true}) {
      protocol::LoggerSettings settings = logger::factory_settings();
      settings.bus_khz = bus_khz;
      if (fastest) settings.rate_hz = logger::max_rate_hz(bus_khz);
      SensorBench bench(settings);
      for (const int first : {0, 2}) bench.imu(first).set_fault(emulator::Mpu6050Fault::kDead);
      bench.run_ms(400);
      CHECK(bench.sampler.imu_present() == 0x0A);
      int early = 0, instants = 0;
      for (const uint64_t end_us = bench.t_us + 2000000; bench.t_us < end_us; ++instants) {
        bench.tick();
        CHECK(bench.valid(1) && bench.valid(3) && bench.interrupt_us < bench.period_us());
        for (const tfsat_test::CountingPort* port : {&bench.port_a, &bench.port_b}) {
          const auto& last = port->bursts.back();
          const double after_us = static_cast<double>(last.us - bench.before_us);
          CHECK(last.address == SensorBench::address(1));
          early += after_us < logger::imu_offset_us(bus_khz, 1) - 15.0;
          CHECK(after_us < logger::imu_burst_max_us(bus_khz) + 15.0);
        }
      }
      CHECK(early <= 2 * 21);
      CHECK(instants > 2 * bench.settings.rate_hz - 3);
    }
  }
}

// What hits the burst that is only read to pass the time is booked to nobody.
TEST_CASE(a_fault_of_the_burst_that_passes_the_time_costs_no_reading) {
  for (const uint16_t bus_khz : {uint16_t{400}, uint16_t{100}}) {
    protocol::LoggerSettings settings = logger::factory_settings();
    settings.bus_khz = bus_khz;
    settings.rate_hz = logger::max_rate_hz(bus_khz);
    SensorBench bench(settings);
    bench.imu(2).set_fault(emulator::Mpu6050Fault::kDead);
    bench.run_ms(400);
    bench.events.clear();
    int nacks = 0, held = 0, hung = 0;
    for (int i = 0; i < 900; ++i) {
      const int kind = i % 3;
      if (i % 9 < 3 && kind == 0) bench.buses[1].glitch(SensorBench::address(3));
      if (i % 9 < 3 && kind == 1) bench.buses[1].set_stuck(true);
      if (i % 9 < 3 && kind == 2) bench.buses[1].set_hanging(SensorBench::address(3), true);
      bench.tick();
      CHECK(bench.interrupt_us < bench.period_us());
      bench.buses[1].set_hanging(SensorBench::address(3), false);
      if (i % 9 < 3) (kind == 0 ? nacks : kind == 1 ? held : hung) += !bench.valid(3);
      CHECK(bench.valid(0) && bench.valid(1));
    }
    // A glitch that meets an instant in which the first is looked for hits the reading itself. One that
    // hangs at each of its transfers hangs at the reading, too.
    CHECK(nacks <= 25 && held == 0 && hung == 100);
    CHECK(bench.sampler.imu_present() == 0x0B);
    for (const protocol::Event& event : bench.events) CHECK(event.code == EventCode::kSensorMissed);
  }
}

// As slow as its pull-ups may make it, and as fast as none: no transfer is taken for a broken one, and
// the next instant is not late.
TEST_CASE(a_permitted_bus_loses_no_sample) {
  for (const uint32_t rise_ns : {uint32_t{0}, logger::kI2cRiseNs}) {
    for (const uint16_t rate_hz : {uint16_t{280}, uint16_t{1000}}) {
      protocol::LoggerSettings settings = logger::factory_settings();
      settings.rate_hz = rate_hz;
      SensorBench bench(settings);
      for (emulator::I2cBus& bus : bench.buses) bus.set_rise_ns(rise_ns);
      bench.run_ms(300);
      bench.events.clear();
      bench.longest_us = 0;
      CHECK(bench.lost_by_others(1000, -1) == 0 && bench.events.empty());
      CHECK(bench.longest_us < bench.period_us());
    }
  }
}

TEST_CASE(a_bus_slower_than_permitted_is_told_as_such) {
  SensorBench bench;
  bench.run_ms(300);
  bench.events.clear();
  for (emulator::I2cBus& bus : bench.buses) bus.set_rise_ns(2 * logger::kI2cRiseNs);
  bench.run_ms(100);
  CHECK(bench.sampler.imu_present() == 0 && bench.events.size() >= 4);
  for (const protocol::Event& event : bench.events) {
    CHECK(event.arg == static_cast<uint16_t>(protocol::ErrorCode::kBusStuck));
  }
}
