// Support vector regressions in files.
#include "model_kinds.hpp"
#include "standardised_file.hpp"
#include "svr_state.hpp"

namespace repose::surrogate {
namespace {

constexpr std::array kKernels{SvrKernel::linear, SvrKernel::quadratic, SvrKernel::cubic,
                              SvrKernel::gaussian};

std::string coordinate(Eigen::Index k) {
  return fmt::format("u{}", k + 1);
}

}  // namespace

std::optional<ModelContent> write_svr(const Regressor& model) {
  const auto* svr = model.target<SupportVectorRegression>();
  if (svr == nullptr) return std::nullopt;
  const auto& s = SvrAccess::state(*svr);
  ModelContent content{.attributes = {{"kernel", std::string(to_string(s.kernel))},
                                      {"kernel_scale", s.kernel_scale},
                                      {"shift", s.shift},
                                      {"scale", s.scale},
                                      {"offset", s.offset},
                                      {"support_vectors", std::int64_t{s.weights.size()}}}};
  content.add("/columns", columns_table(s.columns));
  table::Table vectors;
  for (Eigen::Index k = 0; k < s.vectors.cols(); ++k)
    add_column(vectors, coordinate(k), doubles(s.vectors.col(k)));
  add_column(vectors, "weight", doubles(s.weights));
  content.add("/support_vectors", std::move(vectors));
  return content;
}

Regressor read_svr(const ModelReader& file, std::vector<Input> inputs) {
  SvrAccess::State s{.columns = read_columns(file, std::move(inputs)),
                     .kernel = file.choice(file.get<std::string>("kernel"), kKernels),
                     .kernel_scale = file.positive_or_zero("kernel_scale"),
                     .shift = file.get<double>("shift"),
                     .scale = file.get<double>("scale"),
                     .offset = file.get<double>("offset")};
  file.check(s.kernel_scale > 0.0, "the kernel scale is 0");
  s.vectors.resize(0, s.columns.count());
  if (file.has_table("/support_vectors")) {
    const table::Table t = file.read("/support_vectors");
    s.weights = vector_of(t.numbers("weight"));
    s.vectors.resize(s.weights.size(), s.columns.count());
    for (Eigen::Index k = 0; k < s.vectors.cols(); ++k)
      s.vectors.col(k) = vector_of(t.numbers(coordinate(k)));
  }
  file.check(s.weights.size() == file.get<std::int64_t>("support_vectors"),
             "/support_vectors does not have as many rows as the attribute support_vectors says");
  return SvrAccess::make(std::move(s));
}

}  // namespace repose::surrogate
