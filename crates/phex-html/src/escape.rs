//! Texts from outside, made harmless.

/// A text as it can stand in HTML, between tags and in quoted attributes.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters have no place in HTML.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{FFFD}'),
            c => out.push(c),
        }
    }
    out
}

/// JSON as it can stand in a script element: no tag begins in it.
pub fn json_in_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_hostile_name_is_markup() {
        let text = escaped("<img src=x onerror='a()'>\"&\u{0}");
        assert_eq!(
            text,
            "&lt;img src=x onerror=&#39;a()&#39;&gt;&quot;&amp;\u{FFFD}"
        );
        assert_eq!(json_in_script("\"</script>\""), "\"\\u003c/script>\"");
    }
}
