#include "pipelines/klems_xml.h"

#include <cstdio>
#include <pugixml.hpp>
#include <sstream>

#include "brdf/klems_matrix.h"
#include "io/atomic_file.h"

namespace micro {
namespace {

constexpr const char* kBasis = "LBNL/Klems Full";
pugi::xml_node append(pugi::xml_node parent, const char* name, const std::string& text) {
  pugi::xml_node node = parent.append_child(name);
  node.text().set(text.c_str());
  return node;
}

std::string number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// A comment holds no two hyphens in a row [XML 1.0 §2.5].
std::string as_comment(std::string text) {
  for (std::size_t at = 0; (at = text.find("--", at)) != text.npos; ++at)
    text.replace(at, 2, "- -");
  return " " + text + " ";
}

void append_basis(pugi::xml_node layer) {
  pugi::xml_node definition = layer.append_child("DataDefinition");
  append(definition, "IncidentDataStructure", "Columns");
  pugi::xml_node basis = definition.append_child("AngleBasis");
  append(basis, "AngleBasisName", kBasis);
  for (const KlemsRing& ring : kKlemsRings) {
    pugi::xml_node block = basis.append_child("AngleBasisBlock");
    append(block, "Theta", number(ring.centre));
    append(block, "nPhis", std::to_string(ring.patches));
    pugi::xml_node bounds = block.append_child("ThetaBounds");
    append(bounds, "LowerTheta", number(ring.low));
    append(bounds, "UpperTheta", number(ring.high));
  }
}

/// A row of the text is one wo, its columns the wi.
std::string matrix_text(std::span<const double> f) {
  std::string text = "\n";
  char number[32];
  for (std::size_t row = 0; row < kKlemsPatches; ++row) {
    for (std::size_t column = 0; column < kKlemsPatches; ++column) {
      std::snprintf(number, sizeof number, "%.6g,", f[row * kKlemsPatches + column]);
      text += number;
    }
    text += '\n';
  }
  return text;
}

void append_reflection(pugi::xml_node layer, const char* direction, const std::string& matrix) {
  pugi::xml_node data = layer.append_child("WavelengthData");
  append(data, "LayerNumber", "System");
  append(data, "Wavelength", "Visible").append_attribute("unit") = "Integral";
  append(data, "SourceSpectrum", "CIE Illuminant D65 1nm.ssp");
  append(data, "DetectorSpectrum", "ASTM E308 1931 Y.dsp");
  pugi::xml_node block = data.append_child("WavelengthDataBlock");
  append(block, "WavelengthDataDirection", direction);
  append(block, "ColumnAngleBasis", kBasis);
  append(block, "RowAngleBasis", kBasis);
  append(block, "ScatteringDataType", "BRDF");
  append(block, "ScatteringData", matrix);
}

}  // namespace

void write_klems_xml(const std::filesystem::path& path, const KlemsXmlHead& head, std::span<const double> f) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  document.append_child(pugi::node_comment).set_value(as_comment(head.comment).c_str());
  pugi::xml_node root = document.append_child("WindowElement");
  root.append_attribute("xmlns") = "http://windows.lbl.gov";
  append(root, "WindowElementType", "System");
  pugi::xml_node layer = root.append_child("Optical").append_child("Layer");
  pugi::xml_node material = layer.append_child("Material");
  append(material, "Name", head.name);
  append(material, "Manufacturer", head.manufacturer);
  append(material, "DeviceType", "Other");
  append_basis(layer);
  const std::string matrix = matrix_text(f);
  for (const char* direction : {"Reflection Front", "Reflection Back"})
    append_reflection(layer, direction, matrix);
  std::ostringstream text;
  document.save(text, " ");
  write_text_file(path, text.str());
}

}  // namespace micro
