// Vectors of three numbers.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const plus = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
const unit = (a) => {
  const size = Math.hypot(...a) || 1;
  return a.map((value) => value / size);
};
const mixed = (a, b, t) => a.map((value, k) => (1 - t) * value + t * b[k]);
// Rotate a vector about a unit axis.
const turned = (a, axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  return plus(plus(a.map((value) => c * value), cross(axis, a), s), axis, (1 - c) * dot(axis, a));
};
