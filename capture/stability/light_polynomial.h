/// \file
/// The logarithm of a lamp's light over the picture as a polynomial. Inside of stability only.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace patinate::capture {

/// Terms of a polynomial in x and y of a degree, constant first. @param x,y  In [-1, 1] over the picture.
[[nodiscard]] Eigen::VectorXd monomials(double x, double y, int order);

/// Robust least squares (Tukey weights): what stands out of the slow course, grains, crystals and streaks, does not
/// count.
/// @param terms  monomials() where the values are; one or more. @returns Their coefficients.
[[nodiscard]] Eigen::VectorXd fit_polynomial(const std::vector<Eigen::VectorXd>& terms,
                                             const std::vector<double>& values);

}  // namespace patinate::capture
