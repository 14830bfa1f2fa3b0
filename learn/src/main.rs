//! `amacrine-learn`: learns the arms of a task.

fn main() {}
