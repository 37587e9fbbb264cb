// The step of expressions that is not made of a few operations, in the dialect of kernel_language.inl and behind
// portable_math.inl.

// Of max(0, x); 0 where a power below 0 would be infinite.
PATINATE_INLINE float step_pow(float x, float exponent) {
  const double least = 1e-30;  // portable_pow() wants no subnormals; below it counts as 0
  const double most = 1e30;    // kExpressionHuge
  const double power = portable_pow((double)x > least ? (double)x : 0.0, (double)exponent);
  return (float)(most < power ? most : power);
}
