// From measurements to the paper's tables: CSV for each, one Markdown text, and the data of the figures.
#pragma once

#include <string>
#include <vector>

#include "tables/tables_measure.h"

namespace gms_ransac {

/// A table of text cells.
struct TextTable {
  std::string name;   ///< of the file, without suffix
  std::string title;  ///< sentence above the table
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// All tables, in the paper's order. Columns whose names end in "ms" or speak of time hold times; all others depend
/// only on images and options.
std::vector<TextTable> makeTables(const std::vector<Measurement>& measurements);

std::string toCsv(const TextTable& table);
std::string toMarkdown(const TextTable& table);

/// Writes NAME.csv for each table and tables.md into the folder. Throws std::runtime_error when a file cannot be
/// written.
void writeTables(const std::string& folder, const std::string& heading, const std::vector<TextTable>& tables);

/// Draws the figures of a folder of tables, or of the CSV file of a sweep; failing costs only a line on stderr.
void plotTables(const std::string& folder_or_sweep);

}  // namespace gms_ransac
