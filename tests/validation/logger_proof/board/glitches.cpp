// glitches RATE_HZ: one transfer with an IMU fails, of each IMU in turn and again and again; prints how
// often, and how many samples that cost in all and at most, of the struck one and of the others:
// "nack COUNT LOST MOST OTHERS" and "timeout ...".
#include <stdio.h>
#include <stdlib.h>

#include "../../../teensy_logger/sensor_bench.h"

namespace {

using tfsat_test::SensorBench;

constexpr int kRounds = 50;   // for each IMU
constexpr int kSamples = 300;  // watched after each

void run(const char* name, uint16_t rate_hz, bool hangs) {
  tfsat::protocol::LoggerSettings settings = tfsat::logger::factory_settings();
  settings.rate_hz = rate_hz;
  SensorBench bench(settings);
  bench.run_ms(300);
  int count = 0, lost = 0, most = 0, others = 0;
  for (int round = 0; round < 4 * kRounds; ++round) {
    const int struck = round % 4;
    tfsat::emulator::I2cBus& bus = bench.bus_of(struck);
    int missing = 0;
    for (int i = 0; i < kSamples; ++i) {
      if (i == 0 && !hangs) bus.glitch(SensorBench::address(struck));
      if (hangs) bus.set_hanging(SensorBench::address(struck), i == 0);
      bench.tick();
      for (int imu = 0; imu < 4; ++imu) (imu == struck ? missing : others) += !bench.valid(imu);
    }
    ++count;
    lost += missing;
    most = missing > most ? missing : most;
  }
  printf("%s %d %d %d %d\n", name, count, lost, most, others);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const uint16_t rate_hz = static_cast<uint16_t>(atoi(argv[1]));
  run("nack", rate_hz, false);
  run("timeout", rate_hz, true);
}
