-- A school may ask a second factor of everybody: the same column with one more value.
ALTER TABLE schools ADD COLUMN second_factor_asked_of TEXT NOT NULL DEFAULT 'nobody'
    CHECK (second_factor_asked_of IN ('nobody', 'teachers', 'everybody'));
UPDATE schools SET second_factor_asked_of = second_factor_of;
ALTER TABLE schools DROP COLUMN second_factor_of;
ALTER TABLE schools RENAME COLUMN second_factor_asked_of TO second_factor_of;
