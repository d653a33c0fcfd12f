//! Limits on waiting are all told, and named once.

use protocol::limits;

#[test]
fn every_limit_is_a_row_of_the_page() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/reliability.md");
    let page = std::fs::read_to_string(page).unwrap();
    for limit in limits::ALL {
        let (variable, default, what) = (limit.variable, limit.default, limit.what);
        let row = format!("| `{variable}` | {default} | {what} |");
        println!("{row}");
        assert!(
            page.contains(&row),
            "docs/reliability.md lacks the line above"
        );
        assert_eq!(limit.duration().as_secs_f64(), default);
    }
    let rows = page.lines().filter(|line| line.starts_with("| `SILLAGE_"));
    assert_eq!(rows.count(), limits::ALL.len());
}
