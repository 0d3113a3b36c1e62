//! Numbers, as `ron` reads them.

use crate::tree::Body;

/// Reads a number. Plain decimals, nearly all there are, need no second reader; suffixes, underscores and other
/// bases are `ron`'s.
pub(super) fn number(text: &str) -> Body {
    let plain = text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e' | b'E'));
    if plain && let Ok(value) = text.parse() {
        return Body::Number { value, integer: text.parse().ok() };
    }
    match ron::from_str::<ron::Value>(text) {
        Ok(ron::Value::Number(number)) => {
            Body::Number { value: number.into_f64(), integer: ron::from_str::<u64>(text).ok() }
        }
        _ => Body::Other("no number"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_ron_reads_them() {
        for text in [
            "0",
            "+1",
            "1.",
            ".5",
            "-.5e3",
            "1e-400",
            "1e400",
            "0.1",
            "16777217",
            "123456789012345678901234567890",
            "18446744073709551615",
            "18446744073709551616",
            "1_000",
            "0x1F",
            "0b101",
            "0o17",
            "1f32",
            "0.1f64",
            "7u8",
            "b'a'",
            "-7i64",
            "3.4028236e38",
            "1e39",
        ] {
            let Ok(expected) = ron::from_str::<f64>(text) else { continue };
            let Body::Number { value, integer } = number(text) else { panic!("{text} is a number") };
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
            assert_eq!(integer, ron::from_str::<u64>(text).ok(), "{text}");
        }
        for text in ["1..2", "1-2", "--1", "1.2.3", "e", "-"] {
            assert!(matches!(number(text), Body::Other(_)), "{text}");
        }
    }
}
