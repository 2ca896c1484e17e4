//! Columns of an instance: its measured quantities, and its estimates by one method.

use analysis::method::Method;
use descriptive::Quantity;

use crate::column::Columns;
use crate::estimate_columns;
use crate::null_reason;
use crate::rows::{InstanceRow, instance_columns};
use crate::trial_entry::{drive_columns, key_columns, provenance_columns};

/// Returns the columns of these rows; `method` is the meaning of their column `method`.
pub(crate) fn columns(
    rows: &[InstanceRow<'_>],
    method: &'static str,
    gap_method: Method,
) -> Vec<crate::column::Column> {
    let mut columns = Columns::new(rows);
    key_columns(&mut columns);
    instance_columns(&mut columns, method);
    drive_columns(&mut columns);
    provenance_columns(&mut columns);
    measured_columns(&mut columns, gap_method);
    estimate_columns::of_instance(&mut columns);
    estimate_columns::of_recording(&mut columns);
    estimate_columns::within_laws(&mut columns);
    null_reason::column(&mut columns, null_reason::of_instance);
    columns.into_list()
}

fn measured_columns(columns: &mut Columns<'_, InstanceRow<'_>>, gap_method: Method) {
    columns.real(
        "start_s",
        "s",
        "start of the instance, from the beginning of the recording",
        |row| row.instance.start_s,
    );
    columns.real("end_s", "s", "end of the instance", |row| {
        row.instance.end_s
    });
    for quantity in Quantity::ALL {
        let (name, unit) = (quantity.names().value, quantity.unit());
        if quantity == Quantity::Gap {
            columns.real(
                name,
                unit,
                "levitation gap by the row's method, mean of the instance's last 5 ms; NaN without a usable estimate, where the model of `trial` does not hold, and if no skin has its σ_t",
                |row| quantity.value(row.findings(), row.instance, row.method),
            );
        } else {
            columns.real(name, unit, quantity.meaning(), |row| {
                quantity.value(row.findings(), row.instance, gap_method)
            });
        }
    }
    columns.real(
        "measured_delta_mu",
        "1",
        "fall of the measured friction, mu_at_rest − mu_at_crest",
        |row| row.instance.delta_mu,
    );
}
