-- Who answers for what people tell a school, where to ask, and how long it is kept, in the school's own words; shown before every survey.
ALTER TABLE schools ADD COLUMN data_notice TEXT NOT NULL DEFAULT '';
