#include "identification/distributions.h"

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

namespace trunnion {

using boost::math::complement;

double chi_square_tail(double value, double freedom) {
  if (freedom <= 0) return 1;
  if (!std::isfinite(value)) return 0;
  return boost::math::cdf(complement(boost::math::chi_squared(freedom), value < 0 ? 0 : value));
}

double f_tail(double value, double freedom1, double freedom2) {
  if (freedom1 <= 0 || freedom2 <= 0) return 1;
  if (!std::isfinite(value)) return 0;
  return boost::math::cdf(complement(boost::math::fisher_f(freedom1, freedom2), value < 0 ? 0 : value));
}

double binomial_tail(double count, double trials, double probability) {
  if (count <= 0) return 1;
  if (count > trials) return 0;
  return boost::math::cdf(complement(boost::math::binomial(trials, probability), count - 1));
}

double chi_square_quantile(double tail, double freedom) {
  return boost::math::quantile(complement(boost::math::chi_squared(freedom), tail));
}

}  // namespace trunnion
