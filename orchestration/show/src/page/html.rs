//! Style, body, script and data in one HTML file that opens without a network.
//!
//! The page is `page.html`, `page.css` and `page.js`, whose animation `plane.js` draws or, with three.js,
//! `space.js`; what it shows is one JSON document inside it. `sillage view` serves the same page, which then
//! asks for the document and for each state.

use serde_json::Value;

/// The page with its data inside.
pub fn page(title: &str, data: &Value) -> String {
    let common = include_str!("page.js");
    let script = match data["dimension"].as_u64() {
        Some(3) => {
            let three = include_str!("three/three.min.js");
            [three, common, include_str!("space.js")].concat()
        }
        _ => [common, include_str!("plane.js")].concat(),
    };
    shell(title, include_str!("page.html"), &script, data)
}

/// Style, body, data and script in one file.
pub fn shell(title: &str, body: &str, script: &str, data: &Value) -> String {
    // In a script element only "</" and "<!" have a meaning, and JSON has both in strings alone.
    let data = data.to_string().replace('<', "\\u003c");
    let title = escape(title);
    let style = include_str!("page.css");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title} – Sillage</title>\n\
         <style>\n{style}</style>\n</head>\n<body>\n{body}\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{script}</script>\n</body>\n</html>\n"
    )
}

/// Text as HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn data_cannot_end_its_script() {
        let page = shell("<a>", "", "", &json!({ "text": "</script><!--" }));
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(page.contains("&lt;a&gt;"));
        for dimension in [2, 3] {
            let page = super::page("run", &json!({ "dimension": dimension }));
            println!("{dimension}: {} bytes", page.len());
            assert_eq!(page.matches("</script").count(), 2);
            assert_eq!(page.contains("WebGLRenderer"), dimension == 3);
        }
    }
}
