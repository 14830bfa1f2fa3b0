//! Networks: layers, their derivatives, and the optimiser.
