// slow_bus RATE_HZ RISE_NS: the sampler reads for ten seconds on buses whose clock lines take so long to
// rise; prints "SAMPLES LOST LONGEST": of each IMU, of all four, and of the interrupt, us.
#include <stdio.h>
#include <stdlib.h>

#include "../../../teensy_logger/sensor_bench.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  tfsat::protocol::LoggerSettings settings = tfsat::logger::factory_settings();
  settings.rate_hz = static_cast<uint16_t>(atoi(argv[1]));
  tfsat_test::SensorBench bench(settings);
  bench.run_ms(300);
  for (tfsat::emulator::I2cBus& bus : bench.buses) {
    bus.set_rise_ns(static_cast<uint32_t>(atoi(argv[2])));
  }
  bench.longest_us = 0;
  const uint64_t first = bench.ticks;
  const int lost = bench.lost_by_others(10000, -1);
  printf("%llu %d %llu\n", static_cast<unsigned long long>(bench.ticks - first), lost,
         static_cast<unsigned long long>(bench.longest_us));
}
