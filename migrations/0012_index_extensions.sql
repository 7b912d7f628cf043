-- Who is to be reminded, and whose waiting rosters go, without reading the tables.
CREATE INDEX assignment_extensions_by_due ON assignment_extensions (due_at);
CREATE INDEX rosters_by_school ON rosters (school_id);
