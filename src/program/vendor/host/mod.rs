//! What the vendor's library offers the micro-controller, as far as a program can be told of it:
//! its names, and what their calls do.
//!
//! - [`request`]: what the micro-controller asks of the array.
//! - [`statement`]: calls that are statements of the chip; [`chip`]: those that are other statements
//!   here; [`byte_parameter`]: their parameters of eight bits.
//! - [`post`]: what a host writes for people.

mod byte_parameter;
pub(super) mod chip;
mod post;
pub(super) mod request;
pub(super) mod statement;

use super::{
    interpreter::value::Value,
    syntax::tree::{FILLED, LIMIT, OF_OTHERS, Width, qualifier},
};
use crate::elementary;

/// What a call does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Something on the array: a word, a macro, an operation of the host.
    Chip,
    /// It begins or ends a kernel.
    Kernel,
    /// It waits for a frame.
    Sync,
    /// It shows a register.
    Show,
    /// It reads a register into memory.
    Read,
    /// Arithmetic on numbers.
    Number,
    /// Of the box, the GUI or the language: nothing on the array.
    Library,
}

/// Whether a name is written as those of the vendor's header, of which not all are known here.
pub(super) fn vendors(name: &str) -> bool {
    ["VS_", "vs_", "SCAMP", "scamp"]
        .iter()
        .any(|begin| name.starts_with(begin))
}

/// What a call of this name with so many arguments does.
pub(super) fn role(name: &str, given: usize) -> Role {
    match name {
        "scamp5_kernel_begin"
        | "scamp5_kernel_end"
        | "scamp5_dynamic_kernel_begin"
        | "scamp5_dynamic_kernel_end"
        | "scamp5_kernel_begin_print" => Role::Kernel,
        "vs_frame_loop_control" | "vs_wait_frame_trigger" => Role::Sync,
        "scamp5_output_image"
        | "scamp5_output_areg"
        | "scamp5_output_dreg"
        | "scamp5_output_bitstack_bit" => Role::Show,
        "scamp5_output_events"
        | "scamp5_output_boundingbox"
        | "scamp5_scan_events"
        | "scamp5_scan_events_cr"
        | "scamp5_scan_events_rc"
        | "scamp5_scan_boundingbox"
        | "scamp5_scan_dreg"
        | "scamp5_scan_areg"
        | "scamp5_scan_areg_8x8"
        | "scamp5_scan_areg_mean_8x8"
        | "scamp5_read_areg"
        | "scamp5_global_or"
        | "scamp5_global_sum_16"
        | "scamp5_global_sum_64"
        | "scamp5_global_sum_fast"
        | "scamp5_global_sum_sparse" => Role::Read,
        _ if given > 0 && number(name, &NUMBERS[..given.min(3)]).is_some() => Role::Number,
        FILLED | LIMIT | OF_OTHERS | "sizeof" | "dynamic_cast" | "back_inserter"
        | "front_inserter" | "inserter" => Role::Library,
        // The GUI of the box, its memory, lights, pins and messages; the language's own library.
        _ if name.starts_with("vs_")
            || name.starts_with("VS_")
            || name.starts_with("scamp5_display_")
            || name.starts_with("scamp5_output_bitstack_")
            || name.starts_with("std_")
            || name == MOVE_TO_HEAP
            || LIBRARY.contains(&name)
            || ALGORITHMS.contains(&name) =>
        {
            Role::Library
        }
        _ => Role::Chip,
    }
}

/// Numbers that every function of the mathematical library takes.
const NUMBERS: [f64; 3] = [0.5; 3];

/// What a function of the mathematical library gives; `None` where it is none. The name may end
/// in `f`, as those for `float` do.
pub(super) fn number(name: &str, given: &[f64]) -> Option<f64> {
    let base = match name {
        "roundf" | "floorf" | "ceilf" | "truncf" | "sqrtf" | "cbrtf" | "fabsf" | "sinf"
        | "cosf" | "tanf" | "asinf" | "acosf" | "atanf" | "sinhf" | "coshf" | "tanhf" | "expf"
        | "exp2f" | "logf" | "log2f" | "log10f" | "powf" | "atan2f" | "fminf" | "fmaxf"
        | "fmodf" | "hypotf" | "rintf" | "nearbyintf" | "lroundf" | "lrintf" | "asinhf"
        | "acoshf" | "atanhf" | "expm1f" | "log1pf" | "erff" | "erfcf" | "tgammaf"
        | "copysignf" | "fdimf" | "fmaf" | "remainderf" | "ldexpf" | "scalbnf" => {
            &name[..name.len() - 1]
        }
        name => name,
    };
    Some(match (base, given) {
        ("abs" | "fabs" | "labs" | "llabs", [x]) => x.abs(),
        ("sqrt", [x]) => x.sqrt(),
        ("cbrt", [x]) => libm::cbrt(*x),
        ("floor", [x]) => x.floor(),
        ("ceil", [x]) => x.ceil(),
        ("round" | "lround" | "llround", [x]) => x.round(),
        ("rint" | "nearbyint" | "lrint" | "llrint", [x]) => x.round_ties_even(),
        ("trunc", [x]) => x.trunc(),
        ("sin", [x]) => elementary::sin(*x),
        ("cos", [x]) => elementary::cos(*x),
        ("tan", [x]) => libm::tan(*x),
        ("asin", [x]) => libm::asin(*x),
        ("acos", [x]) => libm::acos(*x),
        ("atan", [x]) => libm::atan(*x),
        ("sinh", [x]) => elementary::sinh(*x),
        ("cosh", [x]) => elementary::cosh(*x),
        ("tanh", [x]) => elementary::tanh(*x),
        ("exp", [x]) => elementary::exp(*x),
        ("exp2", [x]) => elementary::pow(2.0, *x),
        ("log", [x]) => elementary::ln(*x),
        ("log2", [x]) => elementary::log2(*x),
        ("log10", [x]) => elementary::log10(*x),
        ("asinh", [x]) => libm::asinh(*x),
        ("acosh", [x]) => libm::acosh(*x),
        ("atanh", [x]) => libm::atanh(*x),
        ("expm1", [x]) => libm::expm1(*x),
        ("log1p", [x]) => libm::log1p(*x),
        ("erf", [x]) => libm::erf(*x),
        ("erfc", [x]) => libm::erfc(*x),
        ("tgamma", [x]) => libm::tgamma(*x),
        ("isnan", [x]) => x.is_nan().into(),
        ("isinf", [x]) => x.is_infinite().into(),
        ("isfinite", [x]) => x.is_finite().into(),
        ("signbit", [x]) => x.is_sign_negative().into(),
        ("copysign", [x, y]) => x.copysign(*y),
        ("fdim", [x, y]) => libm::fdim(*x, *y),
        ("remainder", [x, y]) => libm::remainder(*x, *y),
        // `as` saturates.
        ("ldexp" | "scalbn", [x, n]) => libm::ldexp(*x, *n as i32),
        ("fma", [x, y, z]) => libm::fma(*x, *y, *z),
        ("min" | "fmin", [x, y]) => x.min(*y),
        ("max" | "fmax", [x, y]) => x.max(*y),
        ("pow", [x, y]) => elementary::pow(*x, *y),
        ("atan2", [y, x]) => libm::atan2(*y, *x),
        ("fmod", [x, y]) => x % y,
        ("hypot", [x, y]) => elementary::hypot(*x, *y),
        ("clamp", [x, low, high]) => x.max(*low).min(*high),
        _ => return None,
    })
}

/// A constant of the language's library.
pub(super) fn constant(name: &str) -> Option<Value> {
    use std::f64::consts;
    Some(match name {
        "M_PI" => Value::Real(consts::PI),
        "M_PI_2" => Value::Real(consts::FRAC_PI_2),
        "M_PI_4" => Value::Real(consts::FRAC_PI_4),
        "M_E" => Value::Real(consts::E),
        "M_SQRT2" => Value::Real(consts::SQRT_2),
        "M_LN2" => Value::Real(consts::LN_2),
        "INFINITY" => Value::Single(f32::INFINITY),
        "NAN" => Value::Single(f32::NAN),
        "HUGE_VAL" => Value::Real(f64::INFINITY),
        "CHAR_BIT" => Value::Whole(8),
        "FLT_MIN" => Value::Single(f32::MIN_POSITIVE),
        "DBL_MIN" => Value::Real(f64::MIN_POSITIVE),
        "FLT_MAX" => Value::Single(f32::MAX),
        "FLT_EPSILON" => Value::Single(f32::EPSILON),
        "DBL_MAX" => Value::Real(f64::MAX),
        "DBL_EPSILON" => Value::Real(f64::EPSILON),
        "INT8_MIN" | "SCHAR_MIN" | "CHAR_MIN" => Value::Whole(i64::from(i8::MIN)),
        "INT8_MAX" | "SCHAR_MAX" | "CHAR_MAX" => Value::Whole(i64::from(i8::MAX)),
        "UINT8_MAX" | "UCHAR_MAX" => Value::Whole(i64::from(u8::MAX)),
        "INT16_MIN" | "SHRT_MIN" => Value::Whole(i64::from(i16::MIN)),
        "INT16_MAX" | "SHRT_MAX" => Value::Whole(i64::from(i16::MAX)),
        "UINT16_MAX" | "USHRT_MAX" => Value::Whole(i64::from(u16::MAX)),
        "INT32_MIN" | "INT_MIN" => Value::Whole(i64::from(i32::MIN)),
        "INT32_MAX" | "INT_MAX" => Value::Whole(i64::from(i32::MAX)),
        "UINT32_MAX" | "UINT_MAX" => Value::Wide(i64::from(u32::MAX), Width::Unsigned),
        "INT64_MIN" | "LONG_MIN" | "LLONG_MIN" => Value::Wide(i64::MIN, Width::Long),
        "INT64_MAX" | "LONG_MAX" | "LLONG_MAX" => Value::Wide(i64::MAX, Width::Long),
        "UINT64_MAX" | "ULONG_MAX" | "ULLONG_MAX" | "SIZE_MAX" | "npos" => Value::size_t(-1),
        // Streams of text, and what sets how they write.
        "cout" | "cerr" | "clog" | "endl" | "flush" | "hex" | "dec" | "fixed" => {
            Value::Unknown("what a stream of text holds".into())
        }
        _ => return None,
    })
}

/// What is only there where the vendor simulates the chip.
pub(super) fn simulates(name: &str) -> bool {
    let space = qualifier(name).unwrap_or_default();
    matches!(space.trim_start_matches("::"), "vs_sim" | "scamp5_sim")
}

/// Algorithms of the language's library that are run: [`algorithm`](super::library::algorithm).
pub(super) const ALGORITHMS: [&str; 40] = [
    "reverse",
    "rotate",
    "sort",
    "stable_sort",
    "fill",
    "fill_n",
    "iota",
    "copy",
    "copy_if",
    "copy_n",
    "iter_swap",
    "min_element",
    "max_element",
    "accumulate",
    "count",
    "find",
    "for_each",
    "transform",
    "remove",
    "remove_if",
    "unique",
    "replace",
    "generate",
    "lower_bound",
    "upper_bound",
    "binary_search",
    "count_if",
    "find_if",
    "find_if_not",
    "any_of",
    "all_of",
    "none_of",
    "inner_product",
    "equal",
    "distance",
    "next",
    "prev",
    "memset",
    "memcpy",
    "memmove",
];

/// What moves the words of a kernel to the micro-controller's memory.
pub(super) const MOVE_TO_HEAP: &str = "move_to_heap";

const LIBRARY: [&str; 68] = [
    "allow_highspeed",
    "scamp5_bind_io_agent",
    "scamp5_get_io_agent",
    "scamp5_kernel_print_debug_info",
    "print_debug_info",
    "display",
    "printf",
    "sprintf",
    "snprintf",
    "srand",
    "rand",
    "malloc",
    "free",
    "to_string",
    "assert",
    "swap",
    "make_pair",
    "random_device",
    "fflush",
    "memcmp",
    "strlen",
    "strcpy",
    "strncpy",
    "strcat",
    "strncat",
    "strcmp",
    "strncmp",
    "atoi",
    "atof",
    "setw",
    "setprecision",
    "exit",
    "puts",
    "scamp5_verbose_str",
    "strchr",
    "tolower",
    "toupper",
    "isdigit",
    "isalpha",
    "isspace",
    "__builtin_popcount",
    "__builtin_popcountl",
    "__builtin_popcountll",
    "__builtin_ctz",
    "__builtin_ctzll",
    "__builtin_clz",
    "__builtin_clzll",
    "stoi",
    "stof",
    "time",
    "clock",
    "calloc",
    "realloc",
    "fopen",
    "fclose",
    "fprintf",
    "fscanf",
    "fgets",
    "fputs",
    "fread",
    "fwrite",
    "feof",
    "perror",
    "getchar",
    "getenv",
    "system",
    "sleep",
    "usleep",
];

/// What an object of `<random>` draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Random {
    /// 32 bits.
    Bits,
    /// Whole numbers from the first parameter to the second.
    Whole,
    /// Reals from the first parameter up to the second.
    Real,
    /// Normally distributed, of a mean and a deviation.
    Normal,
    /// True with a probability.
    Flag,
}

impl Random {
    /// Of a class of the library.
    pub(super) fn named(class: &str) -> Option<Self> {
        Some(match class {
            "random_device"
            | "mt19937"
            | "mt19937_64"
            | "default_random_engine"
            | "minstd_rand"
            | "minstd_rand0" => Self::Bits,
            "uniform_int_distribution" => Self::Whole,
            "uniform_real_distribution" => Self::Real,
            "normal_distribution" => Self::Normal,
            "bernoulli_distribution" => Self::Flag,
            _ => return None,
        })
    }

    /// The parameters of an object that was made without.
    pub(super) const fn parameters(self) -> [f64; 2] {
        match self {
            Self::Bits => [0.0, 0.0],
            Self::Whole => [0.0, i32::MAX as f64],
            Self::Real | Self::Normal => [0.0, 1.0],
            Self::Flag => [0.5, 0.0],
        }
    }
}
