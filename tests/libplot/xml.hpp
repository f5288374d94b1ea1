// Reads the XML that figures are written in, strictly: what is not well-formed throws.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace repose::plot {

struct Element {
  std::string tag;
  std::map<std::string, std::string> attributes;
  std::string text;  ///< directly inside and inside of children
  std::vector<Element> children;

  double number(const std::string& name) const { return std::stod(attributes.at(name)); }
  bool has_class(const std::string& name) const {
    const auto found = attributes.find("class");
    return found != attributes.end() && found->second == name;
  }
  /// All elements below with this tag, depth first.
  std::vector<Element> all(const std::string& wanted) const {
    std::vector<Element> result;
    for (const Element& child : children) {
      if (child.tag == wanted) result.push_back(child);
      for (Element& e : child.all(wanted)) result.push_back(std::move(e));
    }
    return result;
  }
  /// The first element below with this class; throws if there is none.
  Element of_class(const std::string& name) const {
    for (const char* kind : {"g", "rect", "line", "path"})
      for (const Element& e : all(kind))
        if (e.has_class(name)) return e;
    throw std::runtime_error("no element of class " + name);
  }
};

class XmlReader {
 public:
  explicit XmlReader(std::string_view text) : rest_(text) {}

  Element document() {
    Element root = element();
    skip_blanks();
    require(rest_.empty(), "text after the root");
    return root;
  }

 private:
  static void require(bool condition, const char* what) {
    if (!condition) throw std::runtime_error(std::string("not well-formed: ") + what);
  }
  void skip_blanks() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \n"), rest_.size()));
  }
  void expect(std::string_view token) {
    require(rest_.starts_with(token), "unexpected token");
    rest_.remove_prefix(token.size());
  }
  std::string name() {
    const std::size_t end =
        rest_.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-:");
    require(end != 0 && end != std::string_view::npos, "a name is missing");
    std::string result(rest_.substr(0, end));
    rest_.remove_prefix(end);
    return result;
  }
  static std::string decoded(std::string_view raw) {
    const std::map<std::string_view, char> entities = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}};
    std::string result;
    while (!raw.empty()) {
      require(raw.front() != '<', "a naked <");
      if (raw.front() != '&') {
        require(static_cast<unsigned char>(raw.front()) >= 0x20 || raw.front() == '\n', "control");
        result += raw.front();
        raw.remove_prefix(1);
        continue;
      }
      const auto entity = entities.find(raw.substr(0, raw.find(';') + 1));
      require(entity != entities.end(), "an unknown entity");
      result += entity->second;
      raw.remove_prefix(entity->first.size());
    }
    return result;
  }
  void attributes_of(Element& e) {
    for (skip_blanks(); !rest_.starts_with('>') && !rest_.starts_with("/>"); skip_blanks()) {
      const std::string key = name();
      expect("=\"");
      const std::size_t end = rest_.find('"');
      require(end != std::string_view::npos, "an open attribute");
      require(e.attributes.emplace(key, decoded(rest_.substr(0, end))).second, "attribute twice");
      rest_.remove_prefix(end + 1);
    }
  }
  Element element() {
    expect("<");
    Element e;
    e.tag = name();
    attributes_of(e);
    if (rest_.starts_with("/>")) {
      expect("/>");
      skip_blanks();
      return e;
    }
    expect(">");
    for (;;) {
      const std::size_t end = rest_.find('<');
      require(end != std::string_view::npos, "an open element");
      const std::string text = decoded(rest_.substr(0, end));
      if (text != "\n") e.text += text;
      rest_.remove_prefix(end);
      if (rest_.starts_with("</")) break;
      e.children.push_back(element());
      e.text += e.children.back().text;
    }
    expect("</");
    require(name() == e.tag, "a wrong end tag");
    expect(">");
    if (rest_.starts_with('\n')) rest_.remove_prefix(1);
    return e;
  }
  std::string_view rest_;
};

inline Element read_xml(std::string_view text) {
  return XmlReader(text).document();
}

}  // namespace repose::plot
