#include "tools/calibrate/print/pdf.h"

#include <fmt/format.h>

#include <vector>

namespace copresence::calibrate {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '(' || c == ')' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

// Drawing operators in millimetres from the bottom left corner. All rectangles are one path: filled one by one, a viewer
// would show seams between those that touch.
std::string content_of(const Page& page, double height_mm) {
  std::string out = fmt::format("{0:.10f} 0 0 {0:.10f} 0 0 cm\n0 g\n", kPointsPerMm);
  for (const Rectangle& r : page.black) {
    out +=
        fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", r.x, height_mm - r.y - r.height, r.width, r.height);
  }
  out += "f\n";
  for (const Text& t : page.texts) {
    out += fmt::format("BT /F1 {:.3f} Tf {:.3f} {:.3f} Td ({}) Tj ET\n", t.height_mm, t.x, height_mm - t.y,
                       escaped(t.text));
  }
  return out;
}

}  // namespace

std::string to_pdf(const Sheet& sheet) {
  std::vector<std::string> objects;  // numbered from 1
  const std::size_t first_page = 4;  // catalog, page tree, font; then each page and its content
  std::string kids;
  for (std::size_t i = 0; i < sheet.pages.size(); ++i) kids += fmt::format("{} 0 R ", first_page + 2 * i);
  objects.push_back("<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>");
  objects.push_back(fmt::format("<< /Type /Pages /Kids [ {}] /Count {} >>", kids, sheet.pages.size()));
  objects.push_back("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>");
  for (std::size_t i = 0; i < sheet.pages.size(); ++i) {
    objects.push_back(fmt::format(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Resources << /Font << /F1 3 0 R >> >> "
        "/Contents {} 0 R >>",
        sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm, first_page + 2 * i + 1));
    const std::string content = content_of(sheet.pages[i], sheet.height_mm);
    objects.push_back(fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content));
  }
  std::string pdf = "%PDF-1.4\n", places = "0000000000 65535 f \n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    places += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const std::size_t table = pdf.size();
  return pdf + fmt::format("xref\n0 {0}\n{1}trailer\n<< /Size {0} /Root 1 0 R >>\nstartxref\n{2}\n%%EOF\n",
                           objects.size() + 1, places, table);
}

}  // namespace copresence::calibrate
