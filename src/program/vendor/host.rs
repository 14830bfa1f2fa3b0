//! What the vendor's library offers the micro-controller, as far as a program can be told of it.

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
        "abs" | "fabs" | "sqrt" | "floor" | "ceil" | "round" | "sin" | "cos" | "tan" | "exp"
        | "log" | "log2"
            if given == 1 =>
        {
            Role::Number
        }
        "min" | "max" | "fmin" | "fmax" | "pow" | "atan2" if given == 2 => Role::Number,
        "sizeof" => Role::Library,
        // The GUI of the box, its memory, lights, pins and messages; the language's own library.
        _ if name.starts_with("vs_")
            || name.starts_with("VS_")
            || name.starts_with("scamp5_display_")
            || name.starts_with("scamp5_output_bitstack_")
            || name.starts_with("std_")
            || LIBRARY.contains(&name) =>
        {
            Role::Library
        }
        _ => Role::Chip,
    }
}

const LIBRARY: [&str; 26] = [
    "allow_highspeed",
    "move_to_heap",
    "scamp5_bind_io_agent",
    "scamp5_get_io_agent",
    "scamp5_kernel_print_debug_info",
    "print_debug_info",
    "display",
    "printf",
    "sprintf",
    "snprintf",
    "memset",
    "memcpy",
    "srand",
    "rand",
    "malloc",
    "free",
    "to_string",
    "assert",
    "swap",
    "sort",
    "fill",
    "make_pair",
    "random_device",
    "fflush",
    "exit",
    "puts",
];
