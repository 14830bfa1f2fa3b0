//! Codings give back every event, at its time, in its order; what arrives damaged is refused
//! with its place; sizes are those that the definitions say.

use amacrine::{
    event::{
        Event, Packet, Polarity, address,
        codec::{Arrival, CodeBook, CodecError, Coded, Coding, Layout},
    },
    plane::Size,
    unit::Micros,
};
use proptest::prelude::*;

const LAYOUTS: [Layout; 2] = [Layout::Single, Layout::Burst];

fn any_packet() -> impl Strategy<Value = Packet> {
    (1..70_usize, 1..70_usize, 1..6_u8)
        .prop_flat_map(|(height, width, channels)| {
            let event = (
                0..30_u64,
                0..height as u16,
                0..width as u16,
                any::<bool>(),
                0..channels,
            );
            let events = prop::collection::vec(event, 0..200);
            (
                events,
                Just((Size::new(height, width), channels)),
                any::<bool>(),
            )
        })
        .prop_map(|(mut events, (size, channels), in_rows)| {
            // In rows, as an arbiter gives them, or as they come.
            if in_rows {
                events.sort_unstable();
            } else {
                events.sort_by_key(|e| e.0);
            }
            let mut packet = Packet::new(size, channels);
            let event = |(t, y, x, on, channel)| Event {
                t: Micros(t * 1_000_000_007),
                x,
                y,
                polarity: if on { Polarity::On } else { Polarity::Off },
                channel,
            };
            packet.events = events.into_iter().map(event).collect();
            packet
        })
}

fn counts(packet: &Packet) -> Vec<u64> {
    let mut counts = vec![0; packet.channels.into()];
    for e in &packet.events {
        counts[usize::from(e.channel)] += 1;
    }
    counts
}

fn codings(packet: &Packet) -> Vec<Coding> {
    let books = [None, Some(CodeBook::from_counts(&counts(packet)))];
    LAYOUTS
        .into_iter()
        .flat_map(|layout| books.clone().map(|book| Coding { layout, book }))
        .collect()
}

proptest! {
    #[test]
    fn every_event_comes_back(packet in any_packet()) {
        for coding in codings(&packet) {
            let coded = coding.encode(&packet).unwrap();
            prop_assert_eq!(&coded.decode().unwrap(), &packet.events);
            let costs: u64 = coding.costs(&packet).unwrap().into_iter().map(u64::from).sum();
            prop_assert_eq!(costs + coding.book_bits(), coded.bits);
        }
    }

    /// The bits are the definition's, written one by one into a text of 0s and 1s.
    #[test]
    fn words_are_what_the_table_says(packet in any_packet()) {
        let word = address::AddressWord::new(packet.size, packet.channels);
        let book = CodeBook::from_counts(&counts(&packet));
        let field = |bits: u32, value: u128| -> String {
            (0..bits).rev().map(|i| if value >> i & 1 == 1 { '1' } else { '0' }).collect()
        };
        for coding in codings(&packet) {
            let mut text = String::new();
            if coding.book.is_some() {
                for byte in book.to_bytes() {
                    text += &field(8, byte.into());
                }
            }
            let mut row = None;
            for e in &packet.events {
                if coding.layout == Layout::Burst {
                    if row != Some((e.t, e.y)) {
                        text += "1";
                        text += &field(word.y, e.y.into());
                    }
                    row = Some((e.t, e.y));
                    text += "0";
                } else {
                    text += &field(word.y, e.y.into());
                }
                text += &field(word.x, e.x.into());
                let (bits, kind) = match &coding.book {
                    None => (word.channel, e.channel.into()),
                    Some(book) => book.word(e.channel).unwrap(),
                };
                text += &field(bits, kind);
                text += if e.polarity == Polarity::On { "1" } else { "0" };
            }
            let coded = coding.encode(&packet).unwrap();
            let seen: String = coded.bytes.iter().map(|b| field(8, (*b).into())).collect();
            prop_assert_eq!(coded.bits, text.len() as u64);
            prop_assert!(seen.starts_with(&text));
            prop_assert!(seen[text.len()..].chars().all(|c| c == '0') && seen.len() < text.len() + 8);
        }
    }

    /// Cut anywhere, a stream is refused, and says where it ends.
    #[test]
    fn truncated_words_are_refused(packet in any_packet(), cut: prop::sample::Index) {
        prop_assume!(!packet.events.is_empty());
        for coding in codings(&packet) {
            let whole = coding.encode(&packet).unwrap();
            let bits = cut.index(whole.bits as usize) as u64;
            let mut bytes = whole.bytes[..bits.div_ceil(8) as usize].to_vec();
            if !bits.is_multiple_of(8) {
                *bytes.last_mut().unwrap() &= 0xFF << (8 - bits % 8);
            }
            let short = Coded { bytes, bits, ..whole };
            match short.decode().unwrap_err() {
                CodecError::Truncated { end, .. } => prop_assert_eq!(end, bits),
                CodecError::Book { .. } => prop_assert!(bits < coding.book_bits()),
                other => prop_assert!(false, "{other}"),
            }
        }
    }

    /// Any bytes at all are decoded or refused, never more events than bits, without a panic.
    #[test]
    fn noise_does_no_harm(
        bytes in prop::collection::vec(any::<u8>(), 0..60),
        spare in 0..8_u64,
        height in 0..70_usize,
        width in 0..70_usize,
        channels in 0..6_u8,
        burst: bool,
        huffman: bool,
        events in prop_oneof![0..50_u64, Just(u64::MAX)],
    ) {
        let bits = (8 * bytes.len() as u64).saturating_sub(spare);
        let coded = Coded {
            size: Size::new(height, width),
            channels,
            layout: LAYOUTS[usize::from(burst)],
            huffman,
            bytes,
            bits,
            arrivals: vec![Arrival { t: Micros(3), events }],
        };
        if let Ok(found) = coded.decode() {
            prop_assert_eq!(found.len() as u64, events);
            prop_assert!(found.len() as u64 <= bits);
            prop_assert!(found.iter().all(|e| usize::from(e.x) < width && usize::from(e.y) < height));
        }
    }
}

fn small() -> Packet {
    let mut packet = Packet::new(Size::new(3, 5), 3);
    packet.events = [(4, 1, 2, 0), (4, 2, 2, 2), (9, 4, 0, 0)]
        .map(|(t, x, y, channel)| Event {
            t: Micros(t),
            x,
            y,
            polarity: Polarity::On,
            channel,
        })
        .to_vec();
    packet
}

#[test]
fn sizes_of_a_small_packet() {
    let packet = small();
    let bits = |layout, book| {
        let coding = Coding { layout, book };
        coding.encode(&packet).unwrap().bits - coding.book_bits()
    };
    // y 2, x 3, kind 2, sign 1.
    assert_eq!(bits(Layout::Single, None), 3 * 8);
    assert_eq!(bits(Layout::Single, None), address::bits(&packet));
    // Two bursts: two times 1 + 2, three times 1 + 3 + 2 + 1.
    assert_eq!(bits(Layout::Burst, None), 2 * 3 + 3 * 7);
    // Kinds 0, 2, 0: one bit each.
    let book = CodeBook::from_counts(&[2, 0, 1]);
    assert_eq!(bits(Layout::Single, Some(book.clone())), 3 * 7);
    assert_eq!(bits(Layout::Burst, Some(book)), 2 * 3 + 3 * 6);
}

#[test]
fn what_cannot_be_written_is_named() {
    let said = |packet: &Packet, book| {
        let layout = Layout::Single;
        let coding = Coding { layout, book };
        let refused = coding.encode(packet).unwrap_err();
        assert_eq!(coding.costs(packet), Err(refused.clone()));
        refused.to_string()
    };
    let packet = small();
    assert_eq!(
        said(&packet, Some(CodeBook::from_counts(&[1, 1, 0]))),
        "event 1: the code book has no word for channel 2"
    );
    let narrow = Packet {
        size: Size::new(3, 4),
        ..packet
    };
    assert_eq!(
        said(&narrow, None),
        "event 2: x 4, y 0, channel 0 on a sensor of 4x3 with 3 channels"
    );
}

#[test]
fn what_is_damaged_is_named() {
    let coded = |layout| Coding { layout, book: None }.encode(&small()).unwrap();
    let said = |coded: &Coded| coded.decode().unwrap_err().to_string();

    let mut outside = coded(Layout::Single);
    outside.bytes[1] = 0xFF;
    assert_eq!(said(&outside), "bit 8: row 3, of a sensor that has 3");

    let mut more = coded(Layout::Single);
    more.arrivals.pop();
    assert_eq!(
        said(&more),
        "bit 16: all events are read, and 8 bits are left"
    );

    let mut fewer = coded(Layout::Single);
    fewer.arrivals[1].events = 2;
    assert_eq!(
        said(&fewer),
        "bit 24: the words end at bit 24, within event 3, before its row"
    );

    let mut bytes = coded(Layout::Single);
    bytes.bytes.pop();
    assert_eq!(said(&bytes), "24 bits are 3 bytes; there are 2");

    let mut column_first = coded(Layout::Burst);
    column_first.bytes[0] &= 0x7F;
    assert_eq!(
        said(&column_first),
        "bit 0: the words begin with a column, before any row"
    );
    // The leading bit of the first column.
    let mut two_rows = coded(Layout::Burst);
    two_rows.bytes[0] |= 1 << 4;
    assert_eq!(
        said(&two_rows),
        "bit 3: a second row where the first has no column yet"
    );
    let mut padding = coded(Layout::Burst);
    *padding.bytes.last_mut().unwrap() |= 1;
    assert_eq!(
        said(&padding),
        "byte 3: the bits behind the last word are not zero"
    );
}

#[test]
fn the_word_of_a_commercial_sensor() {
    // Prophesee's GenX320 sends 9 + 9 + 1 bits over its AER port (its encoding-format page).
    let mut packet = Packet::new(Size::new(320, 320), 1);
    packet.events = vec![Event {
        channel: 0,
        ..small().events[0]
    }];
    let coding = Coding {
        layout: Layout::Single,
        book: None,
    };
    assert_eq!(coding.costs(&packet), Ok(vec![19]));
}
