#include "mpu6050.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tfsat {
namespace emulator {

using namespace mpu6050;

namespace {

constexpr double kStandardGravity_m_s2 = 9.80665;
constexpr double kRadPerDeg = 0.017453292519943295;
constexpr double kTick_us = 1e6 * LowPass::kTick_s;  // 8 kHz
constexpr uint64_t kWanderTicks = 80;  // 10 ms
constexpr double kWanderStep_s = static_cast<double>(kWanderTicks) * LowPass::kTick_s;
constexpr double kStop_rad_s = 5000.0 * kRadPerDeg;  // beyond every range, so that it clips behind every filter
constexpr double kSaturatedGain = 10.0;

struct Filter {
  double hz, delay_ms;
};
// What tells parts apart. Filters for DLPF_CFG, and for A_DLPF_CFG where there is one, 0 to 7.
struct Part {
  Filter gyro[8], accel[8];
  double counts_per_c, zero_c;
  uint8_t power_after_reset;  // PWR_MGMT_1
  bool has_accel_config_2;
};
// RM registers 26, 65, 107. For 7 ("reserved", 8 kHz) no figures are given: nothing is filtered.
constexpr Part kMpu6050 = {
    {{256, 0.98}, {188, 1.9}, {98, 2.8}, {42, 4.8}, {20, 8.3}, {10, 13.4}, {5, 18.6}, {256, 0.0}},
    {{260, 0.0}, {184, 2.0}, {94, 3.0}, {44, 4.9}, {21, 8.5}, {10, 13.8}, {5, 19.0}, {260, 0.0}},
    340.0, 36.53, kSleep, false};
// RM-MPU-9250A registers 26, 29, 65, 107: it wakes up measuring.
constexpr Part kMpu9250 = {
    {{250, 0.97}, {184, 2.9}, {92, 3.9}, {41, 5.9}, {20, 9.9}, {10, 17.85}, {5, 33.48}, {3600, 0.17}},
    {{218.1, 1.88}, {218.1, 1.88}, {99, 2.88}, {44.8, 4.88}, {21.2, 8.87}, {10.2, 16.83}, {5.05, 32.48},
     {420, 1.38}},
    333.87, 21.0, 0x01, true};
// DS-000143 gives no delays: as the MPU-9250. Register 107 as for the ICM-20608-G, assumed.
constexpr Part kIcm20689 = [] {
  Part part = kMpu9250;
  part.counts_per_c = 326.8, part.zero_c = 25.0, part.power_after_reset = kSleep;
  return part;
}();

const Part& part_of(uint8_t who_am_i) {
  switch (who_am_i) {
    case 0x70:
    case 0x71:
    case 0x73: return kMpu9250;
    case 0x98: return kIcm20689;
    default: return kMpu6050;
  }
}

// RM registers 27 and 28: LSB per deg/s for FS_SEL, LSB per g for AFS_SEL.
constexpr double kGyroLsbPerDegS[4] = {131.0, 65.5, 32.8, 16.4};
constexpr double kAccelLsbPerG[4] = {16384.0, 8192.0, 4096.0, 2048.0};

bool gyro_at_8khz(uint8_t config) { return (config & 7u) == 0 || (config & 7u) == 7; }

}  // namespace

Mpu6050::Mpu6050(const Mpu6050Parameters& parameters)
    : parameters_(parameters),
      tick_length_us_(kTick_us / (1.0 + 1e-6 * parameters.clock_ppm)),
      noise_(parameters.seed),
      temperature_noise_(~parameters.seed),
      wander_noise_(parameters.seed ^ 0x3A4DE5u) {
  reset_registers();
}

void Mpu6050::power_up(uint64_t t_us) {
  now_us_ = std::max(now_us_, t_us);
  reset_until_us_ = now_us_;
  std::fill(std::begin(registers_), std::end(registers_), uint8_t{0});
  reset_registers();
}

void Mpu6050::reset_registers() {
  if (fault_ == Mpu6050Fault::kFrozenUntilReset) fault_ = Mpu6050Fault::kNone;
  const bool data_stay = fault_ == Mpu6050Fault::kFrozen;
  std::fill(std::begin(registers_), registers_ + kAccelXoutH, uint8_t{0});
  if (!data_stay) std::fill(registers_ + kAccelXoutH, registers_ + kGyroZoutL + 1, uint8_t{0});
  std::fill(registers_ + kGyroZoutL + 1, std::end(registers_), uint8_t{0});
  registers_[kPwrMgmt1] = part_of(parameters_.who_am_i).power_after_reset;
  registers_[kWhoAmI] = parameters_.who_am_i;
  configure_filters();
  awake_since_us_ = now_us_;
  fill_filters_ = true;
}

void Mpu6050::configure_filters() {
  const Part& part = part_of(parameters_.who_am_i);
  const Filter& gyro = part.gyro[registers_[kConfig] & 7u];
  const Filter& accel = part.accel[registers_[part.has_accel_config_2 ? kAccelConfig2 : kConfig] & 7u];
  for (int i = 0; i < 3; ++i) filters_[i].configure(gyro.hz, 1e-3 * gyro.delay_ms, parameters_.late_s);
  for (int i = 3; i < 6; ++i) filters_[i].configure(accel.hz, 1e-3 * accel.delay_ms, parameters_.late_s);
}

bool Mpu6050::write(uint8_t reg, const uint8_t* data, size_t n) {
  if (fault_ == Mpu6050Fault::kDead || !ready()) return false;
  for (size_t i = 0; i < n; ++i) write_register(static_cast<uint8_t>(reg + i), data[i]);
  return true;
}

void Mpu6050::write_register(uint8_t reg, uint8_t value) {
  const bool read_only = reg >= 0x80 || reg == kWhoAmI || (reg >= kIntStatus && reg <= kGyroZoutL);
  if (read_only) return;
  if (reg == kPwrMgmt1 && (value & kDeviceReset) != 0) {
    reset_registers();
    reset_until_us_ = now_us_ + parameters_.reset_us;
    return;
  }
  const bool woken = reg == kPwrMgmt1 && (registers_[kPwrMgmt1] & kSleep) != 0 && !(value & kSleep);
  registers_[reg] = value;
  if (reg == kConfig || reg == kAccelConfig2) configure_filters();
  if (woken) {
    awake_since_us_ = now_us_;
    fill_filters_ = true;
  }
}

bool Mpu6050::read(uint8_t reg, uint8_t* data, size_t n) {
  if (fault_ == Mpu6050Fault::kDead || !ready()) return false;
  for (size_t i = 0; i < n; ++i) {
    const uint8_t address = static_cast<uint8_t>(reg + i);
    data[i] = address < 0x80 ? registers_[address] : 0;
    if (address == kIntStatus) registers_[kIntStatus] = 0;  // RM register 58: cleared by reading
  }
  return true;
}

Mpu6050::Truth Mpu6050::measured(const Vec3& rate_rad_s, const Vec3& specific_force_m_s2,
                                 double temperature_c) const {
  const Mpu6050Parameters& p = parameters_;
  const Mat3 to_sensor = transpose(p.sensor_to_body);
  const Vec3 force = to_sensor * specific_force_m_s2;
  const Vec3 rate = to_sensor * rate_rad_s;
  const Vec3 drag = p.gyro_bias_rad_s + p.gyro_cross_axis * rate + p.gyro_g_sensitivity * force +
                    (temperature_c - p.reference_c) * p.gyro_bias_slope_rad_s_c;
  const Vec3 scale{p.gyro_scale.x + p.gyro_bend_s.x * std::abs(rate.x), p.gyro_scale.y + p.gyro_bend_s.y * std::abs(rate.y),
                   p.gyro_scale.z + p.gyro_bend_s.z * std::abs(rate.z)};
  Vec3 shown{scale.x * rate.x + drag.x, scale.y * rate.y + drag.y, scale.z * rate.z + drag.z};
  if (p.gyro_shock_limit_m_s2 > 0.0 && dot(force, force) > p.gyro_shock_limit_m_s2 * p.gyro_shock_limit_m_s2) {
    shown = {std::copysign(kStop_rad_s, force.x), std::copysign(kStop_rad_s, force.y),
             std::copysign(kStop_rad_s, force.z)};
  }
  return {{shown.x, shown.y, shown.z, p.accel_scale.x * force.x + p.accel_bias_m_s2.x,
           p.accel_scale.y * force.y + p.accel_bias_m_s2.y,
           p.accel_scale.z * force.z + p.accel_bias_m_s2.z},
          temperature_c};
}

void Mpu6050::sample(uint64_t t_us, const Vec3& rate_rad_s, const Vec3& specific_force_m_s2,
                     double temperature_c) {
  const Truth truth = measured(rate_rad_s, specific_force_m_s2, temperature_c);
  if (!has_truth_) {
    has_truth_ = true;
    last_truth_ = truth;
    while (tick_us(tick_ + 1) <= t_us) ++tick_;
    now_us_ = std::max(now_us_, t_us);
    return;
  }
  const uint64_t from_us = now_us_;
  while (tick_us(tick_ + 1) <= t_us) {
    ++tick_;
    now_us_ = std::max(from_us, tick_us(tick_));
    const double part = t_us > from_us ? static_cast<double>(now_us_ - from_us) /
                                             static_cast<double>(t_us - from_us)
                                       : 1.0;
    Truth between = truth;
    for (int i = 0; i < 6; ++i)
      between.channel[i] = last_truth_.channel[i] +
                           part * (truth.channel[i] - last_truth_.channel[i]);
    tick(between);
  }
  last_truth_ = truth;
  now_us_ = std::max(now_us_, t_us);
}

void Mpu6050::tick(const Truth& truth) {
  if ((registers_[kPwrMgmt1] & kSleep) != 0 || frozen() || fault_ == Mpu6050Fault::kDead) {
    return;
  }
  if (tick_ % kWanderTicks == 0) wander(kWanderStep_s);
  // White noise of density d has the standard deviation d sqrt(rate / 2) at the conversion rate.
  const double spread = std::sqrt(0.5 / LowPass::kTick_s);
  for (int i = 0; i < 6; ++i) {
    const double density =
        i < 3 ? parameters_.gyro_noise_rad_s_rthz : parameters_.accel_noise_m_s2_rthz;
    const double noise = density > 0.0 ? density * spread * noise_.normal() : 0.0;
    double value = truth.channel[i] + noise + (i < 3 ? wander_rad_s_[i] : 0.0);
    const double limit = parameters_.gyro_front_end_limit_rad_s;
    if (i < 3 && limit > 0.0) value = std::fmax(-limit, std::fmin(limit, value));
    if (fill_filters_) filters_[i].reset(value);
    filters_[i].push(value);
  }
  const uint64_t ticks_per_output = gyro_at_8khz(registers_[kConfig]) ? 1 : 8;
  if (fill_filters_ || tick_ % 8 == 0)
    for (int i = 0; i < 3; ++i) accel_held_[i] = filters_[3 + i].output();
  fill_filters_ = false;
  if (now_us_ - awake_since_us_ < parameters_.gyro_startup_us) return;
  const uint64_t period = ticks_per_output * (1u + registers_[kSmplrtDiv]);  // RM register 25
  if (tick_ % period == 0) update_data_registers(truth.temperature_c);
}

void Mpu6050::wander(double duration_s) {
  if (!(parameters_.gyro_wander_rad_s > 0.0)) return;
  const double kept = std::exp(-duration_s / parameters_.gyro_wander_s);
  const double drawn = parameters_.gyro_wander_rad_s * std::sqrt(1.0 - kept * kept);
  for (double& rate : wander_rad_s_) rate = kept * rate + drawn * wander_noise_.normal();
}

void Mpu6050::update_data_registers(double temperature_c) {
  const double gain = fault_ == Mpu6050Fault::kSaturated ? kSaturatedGain : 1.0;
  const double gyro_lsb = gain * kGyroLsbPerDegS[(registers_[kGyroConfig] >> 3) & 3u] / kRadPerDeg;
  const double accel_lsb =
      kAccelLsbPerG[(registers_[kAccelConfig] >> 3) & 3u] / kStandardGravity_m_s2;
  for (int i = 0; i < 3; ++i) {
    put_word(static_cast<uint8_t>(kAccelXoutH + 2 * i), accel_held_[i] * accel_lsb);
    put_word(static_cast<uint8_t>(kGyroXoutH + 2 * i), filters_[i].output() * gyro_lsb);
  }
  const double measured_c =
      temperature_c + parameters_.temperature_noise_c * temperature_noise_.normal();
  const Part& part = part_of(parameters_.who_am_i);
  put_word(kTempOutH, (measured_c - part.zero_c) * part.counts_per_c);
  if ((registers_[kIntEnable] & kDataReady) != 0) registers_[kIntStatus] |= kDataReady;
}

void Mpu6050::put_word(uint8_t reg, double value) {
  const double clipped = std::fmax(-32768.0, std::fmin(32767.0, std::nearbyint(value)));
  const uint16_t word = static_cast<uint16_t>(static_cast<int16_t>(clipped));
  registers_[reg] = static_cast<uint8_t>(word >> 8);
  registers_[reg + 1] = static_cast<uint8_t>(word & 0xFFu);
}

}  // namespace emulator
}  // namespace tfsat
