-- Assignments as they are listed, the latest first: without `id` in it all that were made at one moment are joined and sorted to show a few.
DROP INDEX assignments_by_school;
CREATE INDEX assignments_by_school ON assignments (school_id, made_at, id);
