// Numbers as people read them: as many digits as the uncertainty leaves, and a real minus sign.

const NO_NUMBER = "–";
const MOST_DECIMALS = 6;

function fixed(value, decimals) {
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

// Two significant digits of the uncertainty, and the value to the same place.
function withStd(value, std) {
  if (value === null || value === undefined) return { value: NO_NUMBER, std: null, power: "" };
  if (std === null || std === undefined || !(std > 0)) return { value: significant(value), std: null, power: "" };
  const power = Math.abs(value) >= std ? powerOf(value) : powerOf(std);
  const scale = power === 0 ? 1 : 10 ** power;
  const decimals = Math.min(MOST_DECIMALS, Math.max(0, 1 - Math.floor(Math.log10(std / scale))));
  return {
    value: fixed(value / scale, decimals),
    std: fixed(std / scale, decimals),
    power: power === 0 ? "" : `×10${superscript(power)}`,
  };
}

function significant(value, digits = 4) {
  if (value === null || value === undefined) return NO_NUMBER;
  if (value === 0) return "0";
  const power = powerOf(value);
  if (power !== 0) return `${fixed(value / 10 ** power, digits - 1)}×10${superscript(power)}`;
  return fixed(value, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value)))));
}

// The power of ten to write a number with; 0 where it reads well without.
function powerOf(value) {
  const power = value === 0 ? 0 : Math.floor(Math.log10(Math.abs(value)));
  return power < -3 || power > 5 ? power : 0;
}

const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const superscript = (power) => [...String(power)].map((character) => SUPERSCRIPTS[character]).join("");

const seconds = (t) => `${fixed(t, 3)} s`;
