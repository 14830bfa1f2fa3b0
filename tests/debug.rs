//! Proves that `exec --debug` stops where it is told to and shows what registers hold there:
//! scripts on standard input, against the program's own arithmetic.

mod common;

use std::fs;

use amacrine::plane::Plane;
use common::amacrine;
use ndarray_npy::write_npy;
use tempfile::TempDir;

const PROGRAM: &str = "\
init {
    scamp5_in(C, 3);
}

frame {
    add(B, A, C);
    repeat 2 {
        neg(D, B);
        mov(B, D);
    }
    where(B);
    MOV(R5, FLAG);
    all();
    scamp5_scan_events(R5, on, 9);
    scamp5_read_areg(B, 0, 0);
}
";

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("p.scamp"), PROGRAM).unwrap();
        let a = Plane::from_shape_fn((2, 3), |(y, x)| (y * 3 + x) as f64 - 4.0);
        write_npy(folder.path().join("a.npy"), &a).unwrap();
        Self(folder)
    }

    fn script(&self, commands: &str) -> String {
        let exec = [
            "exec", "p.scamp", "--set", "A=a.npy", "--frames", "3", "--debug",
        ];
        let output = amacrine(self.0.path(), &exec)
            .write_stdin(commands)
            .assert()
            .success()
            .get_output()
            .clone();
        String::from_utf8(output.stdout).unwrap()
    }
}

#[test]
fn steps_go_word_by_word_and_values_are_those_of_the_array() {
    let text = Bench::new().script("step 3\nprint C 1 1\nnext frame\ns\ns\nprint B 2 1\np B 0 0\n");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[..7],
        [
            "frame 0, line 2: scamp5_in(3)",
            "frame 1, line 6: bus(NEWS, A, C)",
            "C at (1, 1) is 3 LSB",
            "frame 2, line 6: bus(NEWS, A, C)",
            "frame 2, line 6: bus(B, NEWS)",
            "frame 2, line 8: bus(NEWS)",
            "B at (2, 1) is 4 LSB",
        ],
        "{text}"
    );
    assert_eq!(lines[7], "B at (0, 0) is -1 LSB");
}

#[test]
fn breaks_stop_in_every_turn_and_only_on_arrival() {
    let text = Bench::new().script(
        "break 8\nbreak\nc\nprint B 0 0\nc\nprint B 0 0\nc\nclear 8\nb 12\nc\nwhere am I\nc\n",
    );
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[1..9],
        [
            "stops before line 8",
            "breaks at line 8",
            "frame 1, line 8: bus(NEWS)",
            "B at (0, 0) is -1 LSB",
            "frame 1, line 8: bus(NEWS)",
            "B at (0, 0) is 1 LSB",
            "frame 2, line 8: bus(NEWS)",
            "no longer stops before line 8",
        ],
        "{text}"
    );
    assert!(text.contains("frame 2, line 12: MOV(R5, FLAG)"), "{text}");
    assert!(text.contains(">  12      MOV(R5, FLAG);\n"), "{text}");
    assert!(
        text.contains("   10      }\n   11      where(B);\n"),
        "{text}"
    );
    assert!(text.contains("the program has ended\n"), "{text}");
}

#[test]
fn registers_are_pictures() {
    let bench = Bench::new();
    let text = bench.script("b 13\nc\nprint B\nprint R5\nprint FLAG\nprint PIX\ndump B b.png\n");
    assert!(
        text.contains("B: -1.00 LSB (black) to 4.00 LSB (white), mean 1.50 LSB\n░▒▓\n"),
        "{text}"
    );
    assert!(text.contains("R5: 4 of 6 pixels are 1\n▒▒█\n"), "{text}");
    assert!(text.contains("FLAG: 4 of 6"), "{text}");
    assert!(
        text.contains("PIX: -127.00 LSB (black) to -127.00 LSB (white), mean -127.00 LSB\n▒▒▒\n")
    );
    let picture = image::open(bench.0.path().join("b.png"))
        .unwrap()
        .to_luma8();
    assert_eq!(picture.dimensions(), (3, 2));
    // (B + 128) of 255.
    assert_eq!(picture.get_pixel(0, 0).0, [127]);
    assert_eq!(picture.get_pixel(2, 1).0, [132]);
}

#[test]
fn the_host_s_readings_are_told_and_the_table_follows() {
    let text = Bench::new().script("b 14\nc\ns\ns\nquit\n");
    assert!(text.contains("  4 events read out\n"), "{text}");
    assert!(text.contains("  read line 15: ADC 129\n"), "{text}");
    assert!(text.contains("frames   "), "the usual table: {text}");
}

#[test]
fn what_is_no_command_is_told_and_the_end_of_input_quits() {
    let text = Bench::new().script(
        "fly\nstep x\nbreak 1\nbreak 99\nbreak x\nclear 3\nprint Q\nprint A 9 9\nprint\ndump A /dev/null/a.png\nhelp\n",
    );
    for message in [
        "`fly` is no command; `help` lists them",
        "`x` is not a number of instructions",
        "no instruction is on line 1; the next is on line 2",
        "no instruction is on line 99 or below",
        "`x` is not a line",
        "there is no break at line 3",
        "Q: no such register; scamp5 has A B C D E F NEWS R0",
        "there is no pixel (9, 9) on an array of 3x2",
        "write `print REG`, `print REG X Y` or `dump REG FILE.png`",
        "/dev/null/a.png",
        "run on to the first instruction of the next frame",
    ] {
        assert!(text.contains(message), "{message:?} in {text}");
    }
}

/// A pattern goes on for ever, but where it is said which frames are shown.
#[test]
fn a_pattern_is_as_long_as_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let text = "//! frames = 2\n\ninit { get_image(C); }\nframe { get_image(D); }\n";
    fs::write(folder.path().join("p.scamp"), text).unwrap();
    let bar = "pattern:bar?width=16&height=12";
    let said = |more: &[&str]| {
        let exec = [&["exec", "p.scamp", "--image", bar][..], more].concat();
        let output = amacrine(folder.path(), &exec).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let own = said(&[]);
    assert!(own.contains("frames   2\n"), "{own}");
    assert!(
        own.contains("the pattern was run for the program's frames"),
        "{own}"
    );
    let slice = said(&["--slice", "..5"]);
    assert!(slice.contains("frames   5\n"), "{slice}");
    assert!(slice.contains("the whole clip was run"), "{slice}");
    let more = said(&["--frames", "3"]);
    assert!(more.contains("frames   3\n"), "{more}");
    assert!(!more.contains("frames = 2"), "{more}");
}

/// What the debugger did not run was not run.
#[test]
fn a_clip_that_is_left_is_not_run_whole() {
    let folder = tempfile::tempdir().unwrap();
    let text = "//! frames = 2\n\ninit { get_image(C); }\nframe { get_image(D); }\n";
    fs::write(folder.path().join("p.scamp"), text).unwrap();
    let clip = ndarray::Array3::<f64>::zeros((5, 4, 5));
    write_npy(folder.path().join("clip.npy"), &clip).unwrap();
    let exec = ["exec", "p.scamp", "--image", "clip.npy", "--debug"];
    let said = |commands: &str| {
        let mut command = amacrine(folder.path(), &exec);
        let output = command.write_stdin(commands).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let left = said("");
    assert!(left.contains("the debugger was left in frame 0"), "{left}");
    assert!(!left.contains("the whole clip was run"), "{left}");
    let whole = said("continue\n");
    assert!(whole.contains("the whole clip was run"), "{whole}");
    assert!(!whole.contains("was left"), "{whole}");
}
