// A peer of benches/peers/peers.py: vertices and one plane for each face, planarity as a penalty that rises, by the Ceres solver.
// ceres_peer IN.obj OUT.obj t|e  prints the processor seconds at which each planarity was first reached, as JSON.
#include <ceres/ceres.h>
#include <sys/resource.h>

#include <Eigen/Dense>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

using Eigen::Vector3d;

struct Mesh {
  std::vector<std::array<double, 3>> points;
  std::vector<std::vector<int>> faces;
  std::set<std::pair<int, int>> edges;
  Vector3d at(int v) const { return Eigen::Map<const Vector3d>(points[v].data()); }
};

Mesh read(const char* path) {
  Mesh mesh;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      std::array<double, 3> p{};
      words >> p[0] >> p[1] >> p[2];
      mesh.points.push_back(p);
    } else if (kind == "f") {
      std::vector<int> face;
      for (int v; words >> v;) face.push_back(v - 1);
      for (size_t i = 0; i < face.size(); i++)
        mesh.edges.insert(std::minmax(face[i], face[(i + 1) % face.size()]));
      mesh.faces.push_back(face);
    }
  }
  return mesh;
}

struct Plane {
  Vector3d centre, normal, axis[2];
  double bend;
};

Plane fit(const Mesh& mesh, const std::vector<int>& face) {
  Plane plane;
  plane.centre.setZero();
  for (int v : face) plane.centre += mesh.at(v) / face.size();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (int v : face) moments += (mesh.at(v) - plane.centre) * (mesh.at(v) - plane.centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments);
  plane.normal = axes.eigenvectors().col(0);
  for (int k : {0, 1}) plane.axis[k] = axes.eigenvectors().col(k + 1);
  plane.bend = 0;
  for (int v : face) plane.bend = std::max(plane.bend, std::abs(plane.normal.dot(mesh.at(v) - plane.centre)));
  return plane;
}

struct Height {
  Plane plane;
  double weight;
  template <class T>
  bool operator()(const T* p, const T* tilt, T* residual) const {
    T height(0.0);
    for (int i = 0; i < 3; i++)
      height += (plane.normal[i] + tilt[0] * plane.axis[0][i] + tilt[1] * plane.axis[1][i]) * (p[i] - plane.centre[i]);
    residual[0] = weight * (height / sqrt(1.0 + tilt[0] * tilt[0] + tilt[1] * tilt[1]) - tilt[2]);
    return true;
  }
};

struct Distance {
  bool torus;
  template <class T>
  bool operator()(const T* p, T* residual) const {
    if (torus) {
      const T ring = sqrt(p[0] * p[0] + p[1] * p[1]) - 3.0;
      residual[0] = sqrt(ring * ring + p[2] * p[2]) - 1.0;
    } else {
      const T a = 0.3 * cos(p[0]), b = 0.2 * cos(p[1]);
      residual[0] = (p[2] - 0.3 * sin(p[0]) - 0.2 * sin(p[1])) / sqrt(1.0 + a * a + b * b);
    }
    return true;
  }
};

struct Hold {
  double weight;
  std::array<double, 3> start;
  template <class T>
  bool operator()(const T* p, T* residual) const {
    for (int i = 0; i < 3; i++) residual[i] = weight * (p[i] - start[i]);
    return true;
  }
};

double seconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_utime.tv_sec + 1e-6 * usage.ru_utime.tv_usec;
}

// Notes when each planarity is first reached; measuring it does not count.
struct Clock : ceres::IterationCallback {
  const Mesh& mesh;
  double started = seconds(), measuring = 0, planarity = 1;
  std::map<std::string, double> reached;
  explicit Clock(const Mesh& mesh) : mesh(mesh) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    const double now = seconds();
    double bend = 0, length = 0;
    for (const auto& face : mesh.faces) bend = std::max(bend, fit(mesh, face).bend);
    for (auto [a, b] : mesh.edges) length += (mesh.at(a) - mesh.at(b)).norm() / mesh.edges.size();
    planarity = bend / length;
    for (const char* goal : {"1e-3", "1e-6", "1e-9"})
      if (planarity <= std::stod(goal)) reached.emplace(goal, now - started - measuring);
    measuring += seconds() - now;
    return planarity < 1e-9 ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
};

int main(int count, char** arguments) {
  if (count != 4) return 2;
  google::InitGoogleLogging(arguments[0]);
  Mesh mesh = read(arguments[1]);
  const auto start = mesh.points;
  const bool torus = arguments[3][0] == 't';
  Clock clock(mesh);
  double weight = 1000;
  for (int stage = 0; stage < 6 && clock.planarity > 1e-9; stage++, weight *= 100) {
    ceres::Problem problem;
    std::vector<std::array<double, 3>> tilts(mesh.faces.size(), {0, 0, 0});
    for (size_t v = 0; v < start.size(); v++) {
      double* p = mesh.points[v].data();
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Distance, 1, 3>(new Distance{torus}), nullptr, p);
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Hold, 3, 3>(new Hold{0.1, start[v]}), nullptr, p);
    }
    for (size_t f = 0; f < mesh.faces.size(); f++) {
      const Plane plane = fit(mesh, mesh.faces[f]);
      for (int v : mesh.faces[f])
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Height, 1, 3, 3>(new Height{plane, weight}), nullptr,
                                 mesh.points[v].data(), tilts[f].data());
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-7;
    options.update_state_every_iteration = true;
    options.logging_type = ceres::SILENT;
    options.callbacks.push_back(&clock);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
  }
  std::ofstream out(arguments[2]);
  out.precision(17);
  for (const auto& p : mesh.points) out << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  for (const auto& face : mesh.faces) {
    out << 'f';
    for (int v : face) out << ' ' << v + 1;
    out << '\n';
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  printf("{\"rss_mb\": %.0f, \"reached\": {", usage.ru_maxrss / 1024.0);
  const char* comma = "";
  for (const auto& [goal, time] : clock.reached) {
    printf("%s\"%s\": %.4f", comma, goal.c_str(), time);
    comma = ", ";
  }
  printf("}}\n");
}
