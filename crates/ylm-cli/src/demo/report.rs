//! The demo's report: one HTML page beside its pictures.

use std::fmt::Write;

/// What the page shows.
pub struct Report {
    /// The sentence under the title: what was baked.
    pub scene: String,
    /// Name and value of what was measured about the bake.
    pub facts: Vec<(String, String)>,
    /// In the order of the page.
    pub sections: Vec<Section>,
}

/// Pictures of one subject.
pub struct Section {
    /// "Overcast sky".
    pub title: String,
    /// What to type for it.
    pub command: String,
    /// Why it is shown.
    pub text: String,
    /// In reading order.
    pub figures: Vec<Figure>,
    /// Cells of this section's row in the table of numbers, see [`NUMBER_COLUMNS`]; none for no row.
    pub numbers: Vec<String>,
    /// The same for `--json`.
    pub json: serde_json::Value,
}

/// A picture with its words.
pub struct Figure {
    /// File name beside the page.
    pub file: String,
    /// "Shadowed, 5 bands".
    pub title: String,
    /// One line more.
    pub text: String,
    /// Pixels, so that the page does not jump while it loads.
    pub size: (usize, usize),
    /// Whether it takes the page's whole width.
    pub is_wide: bool,
}

impl Figure {
    /// The figure across the page.
    #[must_use]
    pub fn wide(self) -> Self {
        Self { is_wide: true, ..self }
    }
}

impl Section {
    /// Pictures stand in rows of three or four, whichever leaves no gap.
    fn columns(&self) -> &'static str {
        let count = self.figures.iter().filter(|figure| !figure.is_wide).count();
        if count % 3 == 0 { "thirds" } else { "quarters" }
    }
}

/// Heads of [`Section::numbers`].
pub const NUMBER_COLUMNS: [&str; 6] =
    ["Light", "Relight", "Reference", "Reference noise", "Error, unshadowed", "Error, shadowed"];

/// The page, complete with its styles.
pub fn html(report: &Report) -> String {
    let mut page = String::new();
    let mut section_text = String::new();
    for section in &report.sections {
        section_text += &section_html(section);
    }
    let facts: String = report
        .facts
        .iter()
        .map(|(name, value)| format!("<tr><td>{}</td><td>{}</td></tr>\n", escape(name), escape(value)))
        .collect();
    let heads: String = NUMBER_COLUMNS.iter().map(|head| format!("<th>{head}</th>")).collect();
    let rows: String =
        report.sections.iter().filter(|section| !section.numbers.is_empty()).map(number_row).collect();
    let _ = write!(
        page,
        r#"<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>ylm demo</title>
<style>
{css}</style>
<main>
<h1>Light transport, baked once, relit at will</h1>
<p class="lead">{scene}</p>
<figure><img src="contact-sheet.png" alt="All pictures of this page on one sheet">
<figcaption><b>Contact sheet</b><span>One row for each of the first four lights; from left to right: unshadowed, shadowed, reference, error</span></figcaption></figure>
{section_text}
<h2>Numbers</h2>
<p>Errors are relative L2 distances of vertex radiance to the brute-force reference, ‖a − b‖ / ‖b‖. The reference lights
each vertex by rays from the light itself and knows no spherical harmonics; its own noise is estimated from two halves of
its rays. What remains is what the bands cannot hold.</p>
<div class="scroll"><table><tr>{heads}</tr>
{rows}</table></div>
<h2>The bake</h2>
<div class="scroll"><table>
{facts}</table></div>
</main>
</html>
"#,
        css = include_str!("report.css"),
        scene = escape(&report.scene),
    );
    page
}

fn section_html(section: &Section) -> String {
    let figures: String = section
        .figures
        .iter()
        .map(|figure| {
            format!(
                "<figure{}><img src=\"{}\" width=\"{}\" height=\"{}\" loading=\"lazy\" alt=\"{title}, {}\">\n\
                 <figcaption><b>{title}</b><span>{}</span></figcaption></figure>\n",
                if figure.is_wide { " class=\"wide\"" } else { "" },
                escape(&figure.file),
                figure.size.0,
                figure.size.1,
                escape(&section.title),
                escape(&figure.text),
                title = escape(&figure.title),
            )
        })
        .collect();
    format!(
        "<h2>{}</h2>\n<p>{} <code>{}</code></p>\n<div class=\"row {}\">\n{figures}</div>\n",
        escape(&section.title),
        escape(&section.text),
        escape(&section.command),
        section.columns(),
    )
}

fn number_row(section: &Section) -> String {
    let cells: String = section.numbers.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
    format!("<tr><td>{}</td>{cells}</tr>\n", escape(&section.title))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
