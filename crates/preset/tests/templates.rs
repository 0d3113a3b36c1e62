//! `wirework new`: each template runs, shows every field, and says the truth about defaults.

use std::collections::{BTreeMap, BTreeSet};

use wirework_preset::{Action, Limits, PresetErrorKind, TEMPLATES, TemplateError, parse, template};

/// Fields that a template shows with an example in place of their default.
const EXAMPLES: [&str; 15] = [
    "object",
    "wires",
    "goal",
    "curve",
    "points",
    "pose",
    "pattern",
    "locators",
    "domains",
    "propagation",
    "cells",
    "closure",
    "tears",
    "opening",
    "gape",
];

/// Byte offsets after the `(` of every struct with named fields, and what it is called, found by asking: a field that exists
/// nowhere is named in an error, together with all fields that do.
fn structs(text: &str) -> Vec<(usize, String, Vec<String>)> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices('(') {
        let probe = format!("{}(nowhere: 1, {}", &text[..at], &text[at + 1..]);
        let Err(errors) = parse(probe.as_bytes(), &Limits::default()) else { continue };
        let [error] = errors.errors() else { continue };
        if error.kind == PresetErrorKind::Name && error.message.contains("has no field `nowhere`") {
            let mut quoted = error.message.split('`').skip(1).step_by(2).map(str::to_owned);
            let owner = quoted.next().expect("an owner");
            found.push((at + 1, owner, quoted.skip(1).collect()));
        }
    }
    found
}

/// The text without its comments: what is shown must be shown as a value.
fn without_comments(text: &str) -> String {
    let line = |line: &str| line.split("//").next().unwrap_or("").to_owned() + "\n";
    text.lines().map(line).collect()
}

/// What stands up to the closing bracket, without what stands in inner brackets.
fn own_text(text: &str) -> String {
    let mut depth = 0;
    let mut own = String::new();
    for c in text.chars() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' if depth == 0 => break,
            ')' | ']' => depth -= 1,
            _ if depth == 0 => own.push(c),
            _ => {}
        }
    }
    own
}

#[test]
fn templates_run_without_a_warning() {
    for name in TEMPLATES {
        let parsed = parse(template(name).unwrap().as_bytes(), &Limits::default()).unwrap();
        assert_eq!(parsed.warnings, [], "{name}");
        let whole = match &parsed.preset.effects[0].action {
            Action::Stitch(stitching) => stitching.pieces.iter().all(|piece| piece.object.is_some()),
            _ => parsed.preset.object.is_some(),
        };
        assert!(whole && parsed.preset.animated, "{name}");
    }
}

#[test]
fn templates_show_every_field() {
    for name in TEMPLATES {
        let text = without_comments(template(name).unwrap());
        let structs = structs(&text);
        assert!(structs.len() > 1, "{name}");
        // What one struct of a kind shows need not be shown by others.
        let mut missing: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
        for (at, owner, fields) in &structs {
            let mut hidden = BTreeSet::new();
            for field in fields {
                let shown = own_text(&text[*at..]).contains(&format!("{field}: "));
                if !shown {
                    hidden.insert(field.clone());
                }
            }
            let all = missing.entry(owner).or_insert_with(|| hidden.clone());
            all.retain(|field| hidden.contains(field));
        }
        missing.retain(|_, fields| !fields.is_empty());
        assert_eq!(missing, BTreeMap::new(), "{name}");
    }
}

#[test]
fn a_default_that_is_shown_is_the_default() {
    for name in TEMPLATES {
        let text = without_comments(template(name).unwrap());
        let whole = parse(text.as_bytes(), &Limits::default()).unwrap();
        let mut checked = 0;
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            let end = start + line.len();
            let key = line.trim().split(':').next().unwrap_or("");
            let one_line = line.trim_end().ends_with(',') && line.contains(": ");
            let simple = one_line && line.matches('(').count() == line.matches(')').count();
            let named = key.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            if simple && named && !EXAMPLES.contains(&key) {
                let without = format!("{}{}", &text[..start], &text[end..]);
                match parse(without.as_bytes(), &Limits::default()) {
                    Ok(parsed) => {
                        assert_eq!(
                            parsed.preset,
                            whole.preset,
                            "{name}: `{}` is not the default",
                            line.trim()
                        );
                        checked += 1;
                    }
                    Err(errors) => {
                        let needed =
                            errors.errors().iter().all(|error| error.message.contains("needs a field"));
                        let original =
                            template(name).unwrap().lines().find(|l| l.trim().starts_with(line.trim()));
                        assert!(needed && original.is_some_and(|l| l.contains("needed")), "{name}: {errors}");
                    }
                }
            }
            start = end;
        }
        assert!(checked > 15, "{name}: only {checked} defaults were checked");
    }
}

#[test]
fn the_limb_that_is_shown_has_the_default_settings() {
    let effect =
        parse(template("ik").unwrap().as_bytes(), &Limits::default()).unwrap().preset.effects.remove(0);
    let Action::Ik(limb) = effect.action else { panic!() };
    assert_eq!(limb.ik, wirework_ik::Ik::default());
}

#[test]
fn lattices_in_comments_run_and_are_shown_whole() {
    let text = template("deform").unwrap();
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let start = lines.iter().position(|line| *line == "//     WireLattice(").expect("a lattice of wires");
    let end = start + lines[start..].iter().position(|line| *line == "//     )").expect("its end");
    let wires: Vec<&str> = lines[start..=end].iter().map(|line| &line[2..]).collect();
    let wires = wires.join("\n");
    let line = lines.iter().find_map(|line| line.strip_prefix("// Lattice(")).expect("a lattice");
    let lattice = format!("Lattice({}", line.split(": the wires").next().unwrap_or(""));
    let preset = format!("Deform(wires: [{wires}], lattice: {lattice})");
    let parsed = parse(preset.as_bytes(), &Limits::default()).unwrap_or_else(|e| panic!("{preset}\n{e}"));
    assert_eq!(parsed.warnings, []);
    // The radius that is shown is the default.
    let without = preset.replacen("radius: 4,", "", 1);
    assert_ne!(without, preset);
    let without = parse(without.as_bytes(), &Limits::default()).expect("good");
    assert_eq!(without.preset, parsed.preset);
    for owner in ["WireLattice(", "Move(", "Lattice(min: (-2"] {
        let own = preset.replacen(owner, &owner.replacen('(', "(nowhere: 1, ", 1), 1);
        let errors = parse(own.as_bytes(), &Limits::default()).unwrap_err();
        let message = errors.errors()[0].message.clone();
        for field in message.split('`').skip(5).step_by(2) {
            // What it has in common with a wire stands there.
            let shown = preset.contains(&format!("{field}: ")) || text.contains(&format!(" {field}: "));
            assert!(shown, "{owner} {field}");
        }
    }
}

#[test]
fn other_names_are_refused() {
    assert!(template("DEFORM").is_ok());
    let error = template("wrinkel").unwrap_err();
    assert!(matches!(&error, TemplateError::Unknown { nearest: Some("wrinkle"), .. }));
    assert_eq!(
        error.to_string(),
        "there is no effect `wrinkel`; expected `deform`, `wrinkle`, `stitch` or `ik`, did you mean `wrinkle`?"
    );
}
