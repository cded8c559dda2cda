"""Cases by which the diagnosis is judged: simulators of other fields, and measurements with a known answer."""
