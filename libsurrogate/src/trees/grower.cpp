#include "grower.hpp"

#include <algorithm>
#include <type_traits>

namespace repose::surrogate::trees {
namespace {

/// Gains that differ by less are equal: the first one found wins.
constexpr double kTie = 1e-9;
/// Of the weighted sum of squares of the responses: (rounding of a response / response)^2.
constexpr double kNoise = 1e-26;

/// By how much the sum of squares about the means falls where `left` is taken from `total`: the
/// weighted squares of two means less that of one, without their cancellation. 0 where the other
/// side is empty, or weighs less than the rounding of the total.
template <class S>
double gain_of(const S& left, const S& total) {
  const double right = total.weight - left.weight;
  const double d = left.response * total.weight - total.response * left.weight;
  return right > 0.0 ? d * d / (total.weight * left.weight * right) : 0.0;
}

bool is_better(double gain, double best) {
  return gain > best * (1.0 + kTie);
}

/// Those with a flag first, both parts in their order.
void partition(std::span<Count> rows, const std::vector<std::uint8_t>& flags,
               std::vector<Count>& others) {
  std::size_t left = 0;
  std::size_t right = 0;
  for (const Count row : rows) {
    const std::size_t flag = flags[row];
    rows[left] = row;
    others[right] = row;
    left += flag;
    right += 1 - flag;
  }
  std::copy_n(others.begin(), right, rows.begin() + static_cast<std::ptrdiff_t>(left));
}

}  // namespace

template <class S>
Grower<S>::Grower(const Columns& columns, const Limits& limits)
    : columns_(columns),
      limits_(limits),
      of_row_(columns.rows()),
      sorted_(columns.sorted().size()),
      bins_(columns.bins()),
      left_of_row_(columns.rows()),
      moved_(columns.rows()) {
  Count levels = 0;
  for (const BinnedColumn& column : columns.binned()) levels = std::max(levels, column.bins);
  left_levels_.resize(levels);
}

template <class S>
void Grower<S>::start(std::span<const double> response, std::span<const double> weight,
                      std::span<const Count> count) {
  double weights = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  rows_.clear();
  for (Count i = 0; i < columns_.rows(); ++i) {
    if (count[i] == 0) continue;
    const double w = weight[i] * count[i];
    rows_.push_back(i);
    weights += w;
    sum += w * response[i];
    squares += w * response[i] * response[i];
  }
  centre_ = sum / weights;
  noise_ = kNoise * squares;
  for (const Count i : rows_) {
    const double w = weight[i] * count[i];
    of_row_[i].weight = w;
    of_row_[i].response = w * (response[i] - centre_);
    if constexpr (std::is_same_v<S, Sums>) of_row_[i].count = count[i];
  }
  for (std::size_t s = 0; s < sorted_.size(); ++s) {
    std::size_t kept = 0;  // without a branch that half of the rows would mispredict
    sorted_[s].resize(columns_.rows());
    for (const Count i : columns_.sorted()[s].order) {
      sorted_[s][kept] = i;
      kept += count[i] > 0 ? 1 : 0;
    }
    sorted_[s].resize(kept);
  }
  draw_ = columns_.in_order();
  level_sets_.clear();
  nodes_.clear();
  nodes_.push_back(node_of(0, static_cast<Count>(rows_.size())));
  depth_ = 0;
}

template <class S>
typename Grower<S>::Growing Grower<S>::node_of(Count begin, Count end) const {
  Growing node{.begin = begin, .end = end};
  for (Count i = begin; i < end; ++i) node.sums += of_row_[rows_[i]];
  return node;
}

template <class S>
void Grower<S>::grow(std::span<const double> response, std::span<const double> weight,
                     std::span<const Count> count, RandomStream& random) {
  start(response, weight, count);
  std::size_t first = 0;
  for (Count splits = 0; depth_ < limits_.maximum_depth && splits < limits_.maximum_splits;) {
    const std::size_t last = nodes_.size();
    Count found = 0;
    for (std::size_t i = first; i < last; ++i) {
      if (may_split(nodes_[i])) nodes_[i].split = find_split(nodes_[i], random);
      if (nodes_[i].split.gain > 0.0) ++found;
    }
    if (found == 0) return;
    const Count left_over = limits_.maximum_splits - splits;
    if (found > left_over) keep_largest(first, left_over);
    splits += std::min(found, left_over);
    ++depth_;
    const bool grows_on = depth_ < limits_.maximum_depth && splits < limits_.maximum_splits;
    for (std::size_t i = first; i < last; ++i)
      if (nodes_[i].split.gain > 0.0) divide(i, grows_on);
    first = last;
  }
}

template <class S>
bool Grower<S>::may_split(const Growing& node) const {
  return node.end - node.begin > 1 && node.sums.rows() >= 2.0 * limits_.minimum_leaf;
}

template <class S>
typename Grower<S>::Split Grower<S>::find_split(const Growing& node, RandomStream& random) {
  Split best{.gain = noise_};
  const std::size_t all = columns_.size();
  if (limits_.predictors >= all) {
    search(node, columns_.in_order(), best);
  } else {
    std::size_t tried = 0;
    while (tried < all && (tried < limits_.predictors || best.gain == noise_)) {
      const std::size_t next = std::max(limits_.predictors, tried + 1);
      const std::size_t begin = tried;
      for (; tried < next; ++tried)
        std::swap(draw_[tried], draw_[tried + static_cast<std::size_t>(random.below(all - tried))]);
      search(node, std::span(draw_).subspan(begin, next - begin), best);
    }
  }
  if (best.gain == noise_) return {};
  if (columns_.is_binned(best.column) && columns_.binned()[best.column].categorical) {
    best.levels = level_sets_.size();
    level_sets_.insert(level_sets_.end(), left_levels_.begin(),
                       left_levels_.begin() + columns_.binned()[best.column].bins);
  }
  return best;
}

template <class S>
void Grower<S>::search(const Growing& node, std::span<const std::size_t> columns, Split& best) {
  if (node.end - node.begin == 2) return search_pair(node, columns, best);
  fill_bins(node, columns);
  for (const std::size_t column : columns) {
    if (!columns_.is_binned(column))
      search_sorted(node, column, best);
    else if (columns_.binned()[column].categorical)
      search_category(node.sums, column, best);
    else
      search_number(node.sums, column, best);
  }
}

/// Two rows can be parted in one way: the first column that can wins. A large tree has many such
/// nodes.
template <class S>
void Grower<S>::search_pair(const Growing& node, std::span<const std::size_t> columns,
                            Split& best) {
  const S& a = of_row_[rows_[node.begin]];
  const S& b = of_row_[rows_[node.begin + 1]];
  const double gain = gain_of(a, node.sums);
  if (std::min(a.rows(), b.rows()) < limits_.minimum_leaf || !is_better(gain, best.gain)) return;
  for (const std::size_t column : columns) {
    const double* x = columns_.values(columns_.input_of(column));
    const double xa = x[rows_[node.begin]];
    const double xb = x[rows_[node.begin + 1]];
    if (xa == xb) continue;
    best = {.gain = gain, .column = column, .below = std::min(xa, xb), .above = std::max(xa, xb)};
    if (!columns_.is_binned(column) || !columns_.binned()[column].categorical) return;
    const bool a_left = a.response / a.weight <= b.response / b.weight;
    const S& left = a_left ? a : b;
    const bool absent_left = 2.0 * left.weight >= node.sums.weight;
    std::fill_n(left_levels_.begin(), columns_.binned()[column].bins,
                static_cast<std::uint8_t>(absent_left ? 1 : 0));
    left_levels_[static_cast<std::size_t>(xa)] = a_left ? 1 : 0;
    left_levels_[static_cast<std::size_t>(xb)] = a_left ? 0 : 1;
    return;
  }
}

template <class S>
void Grower<S>::fill_bins(const Growing& node, std::span<const std::size_t> columns) {
  const std::size_t width = columns_.binned().size();
  if (columns.size() == columns_.size()) {
    std::fill(bins_.begin(), bins_.end(), S());
    for (Count i = node.begin; i < node.end; ++i) {
      const Count* bin = columns_.bins_of(rows_[i]);
      const S row = of_row_[rows_[i]];
      for (std::size_t f = 0; f < width; ++f) bins_[bin[f]] += row;
    }
    return;
  }
  drawn_binned_.clear();
  for (const std::size_t column : columns) {
    if (!columns_.is_binned(column)) continue;
    drawn_binned_.push_back(column);
    const BinnedColumn& b = columns_.binned()[column];
    std::fill_n(bins_.begin() + b.first_bin, b.bins, S());
  }
  for (Count i = node.begin; i < node.end; ++i) {
    const Count* bin = columns_.bins_of(rows_[i]);
    const S row = of_row_[rows_[i]];
    for (const std::size_t f : drawn_binned_) bins_[bin[f]] += row;
  }
}

/// An empty bin repeats the division before it, which is then no better. What is not allowed (0
/// times a gain, or times NaN where the left side is empty) is never better: one branch that is
/// rarely taken instead of three that are hard to predict.
template <class S>
void Grower<S>::search_number(const S& total, std::size_t column, Split& best) const {
  const BinnedColumn& c = columns_.binned()[column];
  const S* bins = bins_.data() + c.first_bin;
  const double least = limits_.minimum_leaf;
  S left{};
  for (Count b = 0; b + 1 < c.bins; ++b) {
    left += bins[b];
    const int allowed = (left.rows() >= least) & (total.rows() - left.rows() >= least);
    const double gain = allowed * gain_of(left, total);
    if (is_better(gain, best.gain)) best = division_after(c, b, column, gain);
  }
}

template <class S>
typename Grower<S>::Split Grower<S>::division_after(const BinnedColumn& c, Count bin,
                                                    std::size_t column, double gain) const {
  const S* bins = bins_.data() + c.first_bin;
  Count above = bin + 1;
  while (bins[bin].rows() == 0.0) --bin;
  while (bins[above].rows() == 0.0) ++above;
  return {.gain = gain, .column = column, .below = c.values[bin], .above = c.values[above]};
}

/// Levels in order of their means: dividing these is best among all divisions [Fisher1958].
template <class S>
void Grower<S>::search_category(const S& total, std::size_t column, Split& best) {
  const BinnedColumn& c = columns_.binned()[column];
  const S* bins = bins_.data() + c.first_bin;
  const double least = limits_.minimum_leaf;
  level_means_.clear();
  for (Count b = 0; b < c.bins; ++b)
    if (bins[b].rows() > 0.0) level_means_.emplace_back(bins[b].response / bins[b].weight, b);
  std::sort(level_means_.begin(), level_means_.end());
  S left{};
  for (std::size_t k = 0; k + 1 < level_means_.size(); ++k) {
    left += bins[level_means_[k].second];
    if (left.rows() < least) continue;
    if (total.rows() - left.rows() < least) break;
    const double gain = gain_of(left, total);
    if (!is_better(gain, best.gain)) continue;
    best = {.gain = gain, .column = column};
    const bool absent_left = 2.0 * left.weight >= total.weight;
    std::fill_n(left_levels_.begin(), c.bins, static_cast<std::uint8_t>(absent_left ? 1 : 0));
    for (std::size_t l = 0; l < level_means_.size(); ++l)
      left_levels_[level_means_[l].second] = static_cast<std::uint8_t>(l <= k ? 1 : 0);
  }
}

template <class S>
void Grower<S>::search_sorted(const Growing& node, std::size_t column, Split& best) const {
  const std::size_t s = column - columns_.binned().size();
  const double* x = columns_.values(columns_.sorted()[s].input);
  const double least = limits_.minimum_leaf;
  const S total = node.sums;
  S left{};
  const Count* order = sorted_[s].data();
  for (Count i = node.begin; i + 1 < node.end; ++i) {
    left += of_row_[order[i]];
    const double below = x[order[i]];
    const double above = x[order[i + 1]];
    if (left.rows() < least || below == above) continue;
    if (total.rows() - left.rows() < least) return;
    const double gain = gain_of(left, total);
    if (is_better(gain, best.gain))
      best = {.gain = gain, .column = column, .below = below, .above = above};
  }
}

/// Among equal gains the first ones.
template <class S>
void Grower<S>::keep_largest(std::size_t first, Count kept) {
  std::vector<std::size_t> layer;
  for (std::size_t i = first; i < nodes_.size(); ++i)
    if (nodes_[i].split.gain > 0.0) layer.push_back(i);
  std::stable_sort(layer.begin(), layer.end(), [this](std::size_t a, std::size_t b) {
    return nodes_[a].split.gain > nodes_[b].split.gain;
  });
  for (std::size_t k = kept; k < layer.size(); ++k) nodes_[layer[k]].split.gain = 0.0;
}

template <class S>
void Grower<S>::divide(std::size_t parent, bool grows_on) {
  const Growing node = nodes_[parent];
  const std::span<Count> rows = std::span(rows_).subspan(node.begin, node.end - node.begin);
  const std::size_t column = node.split.column;
  const double* x = columns_.values(columns_.input_of(column));
  Count left = 0;
  if (columns_.is_binned(column) && columns_.binned()[column].categorical) {
    const std::uint8_t* levels = level_sets_.data() + node.split.levels;
    for (const Count row : rows) left += left_of_row_[row] = levels[static_cast<Count>(x[row])];
  } else {
    for (const Count row : rows)
      left += left_of_row_[row] = static_cast<std::uint8_t>(x[row] <= node.split.below);
  }
  partition(rows, left_of_row_, moved_);
  nodes_[parent].left = static_cast<Count>(nodes_.size());
  nodes_.push_back(node_of(node.begin, node.begin + left));
  nodes_.push_back(node_of(node.begin + left, node.end));
  if (!grows_on || (!may_split(nodes_.back()) && !may_split(nodes_[nodes_.size() - 2]))) return;
  for (std::vector<Count>& order : sorted_)
    partition(std::span(order).subspan(node.begin, node.end - node.begin), left_of_row_, moved_);
}

template <class S>
Forest Grower<S>::forest() const {
  Forest f;
  f.trees.push_back({0, static_cast<std::int32_t>(depth_)});
  f.resize(nodes_.size());
  f.means.reserve(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Growing& node = nodes_[i];
    f.means.push_back(mean(node));
    Node n{.left = static_cast<std::int32_t>(i)};
    if (node.left > 0) {
      const std::size_t column = node.split.column;
      n.input = static_cast<std::int32_t>(columns_.input_of(column));
      n.left = static_cast<std::int32_t>(node.left);
      n.is_categorical = columns_.is_binned(column) && columns_.binned()[column].categorical;
      if (n.is_categorical) {
        n.threshold = static_cast<double>(f.level_sets.size());
        const auto levels = level_sets_.begin() + static_cast<std::ptrdiff_t>(node.split.levels);
        f.level_sets.insert(f.level_sets.end(), levels, levels + columns_.binned()[column].bins);
      } else {
        n.threshold =
            columns_.threshold(columns_.input_of(column), node.split.below, node.split.above);
      }
    }
    f.set(i, n);
  }
  return f;
}

template class Grower<Sums>;
template class Grower<UnitSums>;

}  // namespace repose::surrogate::trees
