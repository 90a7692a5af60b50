#include "tools/calibrate/alignment/resistance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace copresence::alignment {
namespace {

// Fitted normals are a few degrees off, so even a wall seems to resist a motion along it a little: what is less than
// the sine of six degrees, squared, counts for nothing.
constexpr double kNoise = 0.01;

}  // namespace

Resistances measure_resistance(const Equations& equations) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(equations.information);
  Resistances out{solver.eigenvectors(), Eigen::VectorXd::Zero(equations.information.rows())};
  for (Eigen::Index column = 0; column < out.values.size(); ++column) {
    const Eigen::VectorXd direction = out.directions.col(column);
    double resisted = 0, moved = 0;
    for (Eigen::Index row = 0; row < equations.rows.rows(); ++row) {
      double motion = 0;  // squared, of the cameras that this match is about
      for (Eigen::Index camera = 0; camera < direction.size(); camera += 6) {
        if (equations.rows.block<1, 6>(row, camera).isZero(0)) continue;
        motion += direction.segment<6>(camera).squaredNorm();
      }
      const double along = equations.rows.row(row).dot(direction);
      resisted += std::max(0.0, along * along - kNoise * motion);
      moved += motion;
    }
    out.values[column] = moved > 0 ? resisted / moved : 0;
  }
  return out;
}

}  // namespace copresence::alignment
