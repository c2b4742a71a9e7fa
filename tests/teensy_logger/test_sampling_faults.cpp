// Every fault that a sensor or its bus can have, at a random moment, on each sensor, at 280 Hz and
// 1 kHz: the others lose nothing, no instant delays the next, what is bad is told and not believed,
// and what comes back is used again. The seed is printed with each run.
#include <cstdio>
#include <random>

#include "sensor_bench.h"

using namespace tfsat;
using emulator::Mpu6050Fault;
using protocol::ErrorCode;
using protocol::Event;
using protocol::EventCode;
using tfsat_test::kRad;
using tfsat_test::SensorBench;

namespace {

constexpr uint32_t kRuns = 1;  // random moments for each fault, sensor and rate

enum class Fault : uint8_t {
  kNack,
  kHang,              // stops in the middle of its transfers and holds the bus
  kHeldBus,           // SDA held low until it is clocked free
  kShortedBus,        // SDA held low whatever is done
  kForeign,           // another part in its place
  kFrozen,            // no reset helps
  kFrozenUntilReset,
};

struct Case {
  Fault fault;
  const char* name;
  std::vector<ErrorCode> told;  // causes of its fault events, in their order
};

const Case kCases[] = {
    {Fault::kNack, "NACK", {ErrorCode::kSensorMissing}},
    {Fault::kHang, "hang", {ErrorCode::kBusStuck}},
    {Fault::kHeldBus, "held bus", {}},
    {Fault::kShortedBus, "shorted bus", {ErrorCode::kBusStuck}},
    // the new part sleeps before it is asked who it is
    {Fault::kForeign, "foreign", {ErrorCode::kSensorReset, ErrorCode::kSensorForeign}},
    {Fault::kFrozen, "frozen", {ErrorCode::kSensorFrozen}},
    {Fault::kFrozenUntilReset, "frozen until reset", {ErrorCode::kSensorFrozen}},
};

protocol::LoggerSettings at(uint16_t rate_hz, uint16_t bus_khz = 400) {
  protocol::LoggerSettings settings = logger::factory_settings();
  settings.rate_hz = rate_hz;
  settings.bus_khz = bus_khz;
  int32_t detail;
  CHECK(logger::check(settings, detail) == ErrorCode::kNone);
  return settings;
}

void begin(SensorBench& bench, int imu, Fault fault) {
  emulator::I2cBus& bus = bench.bus_of(imu);
  switch (fault) {
    case Fault::kNack: return bench.imu(imu).set_fault(Mpu6050Fault::kDead);
    case Fault::kHang: return bus.set_hanging(SensorBench::address(imu), true);
    case Fault::kHeldBus: return bus.set_stuck(true);
    case Fault::kShortedBus: return bus.set_stuck(true, true);
    case Fault::kForeign: return bench.imu(imu).replace(0x12, bench.t_us);
    case Fault::kFrozen: return bench.imu(imu).set_fault(Mpu6050Fault::kFrozen);
    case Fault::kFrozenUntilReset: break;
  }
  bench.imu(imu).set_fault(Mpu6050Fault::kFrozenUntilReset);
}

void end(SensorBench& bench, int imu, Fault fault) {
  emulator::I2cBus& bus = bench.bus_of(imu);
  if (fault == Fault::kForeign) bench.imu(imu).replace(0x68, bench.t_us);
  bench.imu(imu).set_fault(Mpu6050Fault::kNone);
  bus.set_hanging(SensorBench::address(imu), false);
  bus.set_stuck(false);
}

// Whom the fault strikes: a shorted line takes its bus with it, and a held one nobody.
bool strikes(Fault fault, int faulty, int imu) {
  if (fault == Fault::kHeldBus) return false;
  return fault == Fault::kShortedBus ? faulty / 2 == imu / 2 : faulty == imu;
}

struct Campaign {
  Campaign(uint32_t seed, uint16_t rate_hz, uint16_t bus_khz)
      : random(seed), bench(at(rate_hz, bus_khz)) {
    bench.start_us = random() % 10000;
    bench.run_ms(300);
    CHECK(bench.sampler.imu_present() == 0x0F);
    bench.events.clear();
    bench.run_ms(random() % 200);
  }

  // One tick; what the log would say of each sensor.
  void tick() {
    bench.tick();
    CHECK(bench.interrupt_us < bench.period_us());
    for (int i = 0; i < 4; ++i) {
      samples.push_back({bench.t_us, i, bench.valid(i)});
      if (bench.valid(i)) CHECK_NEAR(bench.instant.sample.imu[i].gyro[0] / 65.5, kRad, 0.1);
    }
  }
  void run_ms(uint32_t ms) {
    for (const uint64_t end_us = bench.t_us + 1000u * ms; bench.t_us < end_us;) tick();
  }
  // What a decoder does with a frozen sensor's event.
  void mark_frozen() {
    for (const Event& event : bench.events) {
      if (event.code != EventCode::kSensorFault) continue;
      const uint64_t since_us = event.time_us - static_cast<uint64_t>(event.value);
      for (Sample& sample : samples) {
        const bool hit = sample.imu == event.index && sample.t_us >= since_us;
        if (hit && sample.t_us < event.time_us) sample.valid = false;
      }
    }
  }

  struct Sample {
    uint64_t t_us;
    int imu;
    bool valid;
  };
  std::mt19937 random;
  SensorBench bench;
  std::vector<Sample> samples;
};

void check_events(const Campaign& campaign, const Case& c, int faulty) {
  for (int imu = 0; imu < 4; ++imu) {
    std::vector<ErrorCode> told;
    int recovered = 0;
    for (const Event& event : campaign.bench.events) {
      if (event.index != imu || event.code == EventCode::kSensorMissed) continue;
      if (event.code == EventCode::kSensorFault) {
        CHECK(recovered == 0);
        told.push_back(static_cast<ErrorCode>(event.arg));
        const bool frozen = told.back() == ErrorCode::kSensorFrozen;
        const bool foreign = told.back() == ErrorCode::kSensorForeign;
        CHECK(frozen ? event.value >= static_cast<int32_t>(protocol::kFrozenUs) &&
                           event.value < static_cast<int32_t>(protocol::kFrozenUs + 4000)
                     : event.value == (foreign ? 0x12 : 0));
      } else {
        CHECK(event.code == EventCode::kSensorRecovered && event.arg == 0 && event.value == 0x68);
        ++recovered;
      }
    }
    const bool struck = strikes(c.fault, faulty, imu);
    CHECK(told == (struck ? c.told : std::vector<ErrorCode>()) && recovered == (struck ? 1 : 0));
  }
}

void run(const Case& c, int faulty, uint32_t seed, uint16_t rate_hz, uint16_t bus_khz) {
  const int before = tfsat_test::failures();
  Campaign campaign(seed, rate_hz, bus_khz);
  SensorBench& bench = campaign.bench;
  const uint64_t began_us = bench.t_us;
  bench.move_to(began_us + campaign.random() % bench.period_us());
  begin(bench, faulty, c.fault);
  campaign.run_ms(500 + campaign.random() % 500);
  const bool cured = c.fault == Fault::kHeldBus || c.fault == Fault::kFrozenUntilReset;
  for (int i = 0; i < 4; ++i) CHECK(bench.valid(i) == (cured || !strikes(c.fault, faulty, i)));
  end(bench, faulty, c.fault);
  const uint64_t ended_us = bench.t_us;
  campaign.run_ms(450);
  CHECK(bench.sampler.imu_present() == 0x0F);

  campaign.mark_frozen();
  uint64_t back_us = 0;
  for (const Event& event : bench.events) {
    if (event.code == EventCode::kSensorRecovered && event.index == faulty) back_us = event.time_us;
  }
  for (const Campaign::Sample& sample : campaign.samples) {
    CHECK(sample.valid == !(strikes(c.fault, faulty, sample.imu) && sample.t_us < back_us));
  }
  CHECK(cured || back_us > ended_us);
  CHECK(back_us < ended_us + 400000 && (back_us > began_us || back_us == 0));
  check_events(campaign, c, faulty);
  if (tfsat_test::failures() > before) {
    std::printf("  %s on IMU %d at %u Hz, seed %u\n", c.name, faulty + 1, rate_hz, seed);
  }
}

void run_all_faults(uint16_t rate_hz, uint16_t bus_khz) {
  uint32_t seed = 20000u + rate_hz;
  for (const Case& c : kCases) {
    for (int faulty = 0; faulty < 4; ++faulty) {
      for (uint32_t k = 0; k < kRuns; ++k) run(c, faulty, ++seed, rate_hz, bus_khz);
    }
  }
  std::printf("  %u Hz, %u kHz: seeds %u to %u\n", rate_hz, bus_khz, 20001u + rate_hz, seed);
}

}  // namespace

TEST_CASE(each_fault_on_each_sensor_at_each_rate_and_clock) {
  run_all_faults(280, 400);
  run_all_faults(1000, 400);
  run_all_faults(280, 100);
}

// One transfer fails, at any time, at any sensor: so many samples of that one, an event, and nothing else. From
// 936 Hz on, and at 100 kHz from 257 Hz on, two bursts leave no time for a look at the settings.
TEST_CASE(one_failed_transfer_costs_the_sample_that_it_hits) {
  const struct {
    uint16_t rate_hz, bus_khz;
    bool hangs;
    int lost;
  } cases[] = {{280, 400, false, 1}, {1000, 400, false, 1}, {280, 100, false, 1}, {283, 100, false, 1},
               {280, 400, true, 1},  {935, 400, true, 1},   {936, 400, true, 2},
               {1000, 400, true, 2}, {250, 100, true, 1},   {256, 100, true, 1},
               {257, 100, true, 2},  {280, 100, true, 2}};
  for (const auto& c : cases) {
    for (int struck = 0; struck < 4; ++struck) {
      SensorBench bench(at(c.rate_hz, c.bus_khz));
      bench.run_ms(300);
      for (int round = 0; round < 4; ++round) {
        bench.events.clear();
        emulator::I2cBus& bus = bench.bus_of(struck);
        int missing = 0;
        for (int i = 0; i < 100; ++i) {
          if (i == 0 && !c.hangs) bus.glitch(SensorBench::address(struck));
          if (c.hangs) bus.set_hanging(SensorBench::address(struck), i == 0);
          bench.tick();
          CHECK(bench.interrupt_us < bench.period_us());
          for (int imu = 0; imu < 4; ++imu) {
            missing += !bench.valid(imu);
            CHECK(bench.valid(imu) || imu == struck);
          }
        }
        CHECK(missing == c.lost && bench.sampler.imu_present() == 0x0F);
        CHECK(bench.events.size() == 1 && bench.events[0].code == EventCode::kSensorMissed &&
              bench.events[0].index == struck && bench.events[0].value == 0);
        const ErrorCode told = c.hangs ? ErrorCode::kBusStuck : ErrorCode::kSensorMissing;
        CHECK(bench.events[0].arg == static_cast<uint16_t>(told));
      }
    }
  }
}

// A look at the settings that fails says nothing of them: no reading is lost, nothing is told, and it
// is asked for again at the next instant, or at the one after where the bus is clocked free first.
TEST_CASE(a_proof_that_fails_is_no_evidence) {
  using ProofFault = tfsat_test::CountingPort::ProofFault;
  const uint16_t cases[][2] = {{280, 400}, {1000, 400}, {250, 100}, {283, 100}};
  for (const auto& c : cases) {
    for (const ProofFault fault : {ProofFault::kNack, ProofFault::kTimeout}) {
      SensorBench bench(at(c[0], c[1]));
      bench.run_ms(300);
      bench.events.clear();
      int failed = 0;
      for (int round = 0; round < 20; ++round) {
        tfsat_test::CountingPort& port = round % 2 ? bench.port_b : bench.port_a;
        port.proof_fault = fault;
        uint64_t failed_us = 0;
        int shown = 0;
        for (const uint64_t end_us = bench.t_us + 150000; bench.t_us < end_us;) {
          const int before = port.proofs;
          bench.tick();
          CHECK((bench.instant.sample.flags & 0x0F) == 0x0F);
          CHECK(bench.interrupt_us < bench.period_us());
          if (failed_us != 0 && shown == 0 && port.proofs > before) {
            const uint32_t instants = fault == ProofFault::kTimeout ? 2 : 1;
            CHECK(bench.t_us - failed_us <= instants * (bench.period_us() + 1));
            ++shown;
          }
          if (failed_us == 0 && port.proof_fault == ProofFault::kNone) failed_us = bench.t_us, ++failed;
        }
      }
      CHECK(failed == 20 && bench.events.empty());
    }
  }
}

// What answers again with other settings is started anew, at once; the accelerometer filter of the later parts is
// one of them.
TEST_CASE(a_sensor_that_lost_a_setting_is_not_believed) {
  const struct {
    uint16_t rate_hz;
    uint8_t part, reg, value;
  } cases[] = {{280, 0x68, emulator::mpu6050::kGyroConfig, 0x18},
               {1000, 0x68, emulator::mpu6050::kGyroConfig, 0x18},
               {280, 0x70, emulator::mpu6050::kAccelConfig2, 0x00}};
  for (const auto& c : cases) {
    SensorBench bench(at(c.rate_hz));
    bench.imu(1).replace(c.part, 0);
    bench.run_ms(300);
    bench.events.clear();
    bench.bus_of(1).glitch(SensorBench::address(1));
    CHECK(bench.imu(1).write(c.reg, &c.value, 1));
    bench.tick();
    CHECK(!bench.valid(1) && bench.events.size() == 1);
    CHECK(bench.events[0].arg == static_cast<uint16_t>(ErrorCode::kSensorReset));
    while (!bench.valid(1)) bench.tick();
    CHECK(bench.t_us - bench.events[0].time_us < 100000);
    CHECK_NEAR(bench.instant.sample.imu[1].gyro[0] / 65.5, kRad, 0.1);
    uint8_t setting = 0xFF;
    CHECK(bench.imu(1).read(c.reg, &setting, 1) && setting != c.value);
  }
}

TEST_CASE(sampling_takes_two_bursts_and_the_angles_cost_nothing) {
  SensorBench bench(at(1000));
  bench.run_ms(300);
  bench.tick();
  CHECK(bench.interrupt_us >= 852 && bench.interrupt_us < 862);
  for (emulator::I2cBus& bus : bench.buses) bus.set_rise_ns(0);
  bench.tick();
  CHECK(bench.interrupt_us >= 780 && bench.interrupt_us < 790);
  SensorBench slow(at(280, 100));
  slow.run_ms(300);
  slow.tick();
  CHECK(slow.interrupt_us >= 3120 && slow.interrupt_us < 3130);
}

// More than one fault at a time costs readings, and never the next instant.
TEST_CASE(faults_that_come_together_do_not_delay_the_next_instant) {
  for (const uint16_t bus_khz : {uint16_t{400}, uint16_t{100}}) {
    std::mt19937 random(bus_khz);
    SensorBench bench(at(logger::max_rate_hz(bus_khz), bus_khz));
    bench.run_ms(300);
    for (int round = 0; round < 40; ++round) {
      for (int i = 0; i < 12; ++i) {
        for (uint32_t n = random() % 3; n > 0; --n) {
          begin(bench, static_cast<int>(random() % 4), static_cast<Fault>(random() % 7));
        }
        bench.tick();
        CHECK(bench.interrupt_us < bench.period_us());
      }
      for (int i = 0; i < 4; ++i) end(bench, i, Fault::kForeign);
      bench.run_ms(400);
      CHECK(bench.sampler.imu_present() == 0x0F);
    }
    CHECK(bench.longest_us > bench.period_us() * 9 / 10);
    std::printf("  %u kHz: at most %u of %u us\n", bus_khz,
                static_cast<unsigned>(bench.longest_us), bench.period_us());
  }
}

TEST_CASE(two_sensors_of_a_bus_that_hang_are_both_told_and_come_back) {
  SensorBench bench(at(1000));
  bench.run_ms(300);
  bench.events.clear();
  bench.buses[0].set_hanging(0x68, true);
  bench.buses[0].set_hanging(0x69, true);
  bench.tick();
  CHECK(bench.port_a.recoveries == 1);
  CHECK(bench.events.size() == 2 && (bench.instant.sample.flags & 0x0F) == 0x0C);
  bench.buses[0].set_hanging(0x68, false);
  bench.buses[0].set_hanging(0x69, false);
  bench.run_ms(300);
  for (const Event& event : bench.events) CHECK(event.code == EventCode::kSensorMissed);
  CHECK(bench.sampler.imu_present() == 0x0F && bench.events.size() == 2);
}

TEST_CASE(a_shorted_bus_is_not_hammered) {
  SensorBench bench;
  bench.run_ms(300);
  bench.buses[1].set_stuck(true, true);
  bench.tick();
  CHECK(bench.port_b.recoveries == 1);
  const int transfers = bench.port_b.transfers;
  bench.run_ms(1000);
  CHECK((bench.instant.sample.flags & 0x0F) == 0x03);
  CHECK(bench.port_b.transfers - transfers <= 36);  // 6 instants of patience
  CHECK(bench.port_b.recoveries <= 18);
}

// At 1 kHz the chip's own 1 kHz beats with ours, and a reading comes twice now and then.
TEST_CASE(a_repeated_reading_is_not_a_freeze) {
  SensorBench bench(at(1000));
  bench.run_ms(300);
  bench.events.clear();
  for (int i = 0; i < 4; ++i) bench.imu(i).set_fault(Mpu6050Fault::kFrozen);
  bench.run_ms(95);
  for (int i = 0; i < 4; ++i) bench.imu(i).set_fault(Mpu6050Fault::kNone);
  CHECK(bench.lost_by_others(1000, -1) == 0 && bench.events.empty());
}

// 10 Hz: two equal readings span 100 ms and mean nothing.
TEST_CASE(a_freeze_is_not_told_from_two_readings) {
  SensorBench bench(at(10));
  bench.run_ms(3000);
  bench.events.clear();
  bench.imu(0).set_fault(Mpu6050Fault::kFrozen);
  bench.run_ms(300);
  CHECK(bench.events.empty());
  bench.run_ms(200);
  CHECK(bench.events.size() == 1);
}

// Not after a reset, and not when a chip that lost its power says zeros.
TEST_CASE(after_a_freeze_only_an_output_that_moves_is_believed) {
  SensorBench bench;
  bench.run_ms(300);
  bench.imu(3).set_fault(Mpu6050Fault::kFrozen);
  bench.run_ms(500);
  bench.events.clear();
  for (int i = 0; i < 2000; ++i) {
    bench.tick();
    CHECK(!bench.valid(3));
    if (i == 1000) bench.imu(3).power_up(bench.t_us);
  }
  CHECK(bench.events.empty());
  bench.imu(3).set_fault(Mpu6050Fault::kNone);
  bench.run_ms(400);
  CHECK(bench.valid(3) && bench.events.size() == 1);
}
