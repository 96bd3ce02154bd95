(* ---- Forms that are nonnegative on a cone: N + S with entries of N >= 0, S nowhere negative, or on both halves ---- *)

Definition entries_nonneg (N : triangle) : bool := forallb (fun r => (0 <=? fst r)%Z && forallb (Z.leb 0) (snd r)) N.
(* Column i added to column j: the cone whose edge e_j gives way to e_i + e_j. *)
Definition join (i j : nat) (row : list Z) : list Z := add row (repeat 0%Z j ++ [nth i row 0%Z]).
Inductive halves := Leaf (N : triangle) | Halve (i j : nat) (s t : halves).
Fixpoint copositive (P rows : list (list Z)) (n : nat) (t : halves) : bool :=
  match t with
  | Leaf N => entries_nonneg N && psd n 1 (madd (matrix (bilinear P rows rows)) (mscale (-1) N))
  | Halve i j s t =>
      (i <? n)%nat && (j <? n)%nat && negb (i =? j)%nat &&
      copositive P (map (join i j) rows) n s && copositive P (map (join j i) rows) n t
  end.

Lemma entries_dot : forall v z, forallb (Z.leb 0) v = true -> Forall (Rle 0) z -> 0 <= dot v z.
Proof.
  induction v as [|a v IH]; intros [|x z] A B; cbn [dot forallb] in *; try lra.
  apply andb_true_iff in A as [a0 A]; apply Z.leb_le, IZR_le in a0; inversion B; subst.
  specialize (IH z A H2); nra.
Qed.
Lemma entries_qf : forall N z, entries_nonneg N = true -> Forall (Rle 0) z -> 0 <= qf N z.
Proof.
  induction N as [|[a v] N IH]; intros [|x z] A B; cbn [qf]; try lra.
  unfold entries_nonneg in *; cbn [forallb fst snd] in A; rewrite !andb_true_iff in A; destruct A as [[a0 A] C].
  apply Z.leb_le, IZR_le in a0; inversion B; subst.
  pose proof (entries_dot v z A H2); specialize (IH z C H2); nra.
Qed.

(* z with r added to its entry i. *)
Fixpoint bump (i : nat) (r : R) (z : list R) : list R :=
  match z, i with x :: z', O => (x + r) :: z' | x :: z', S i' => x :: bump i' r z' | [], _ => [] end.
Lemma bump_length : forall i r z, length (bump i r z) = length z.
Proof. induction i as [|i IH]; intros r [|x z]; cbn [bump length]; auto. Qed.
Lemma dot_bump : forall i r z row, (i < length z)%nat -> dot row (bump i r z) = dot row z + IZR (nth i row 0%Z) * r.
Proof.
  induction i as [|i IH]; intros r [|x z] [|a row] L; cbn [bump dot nth length] in *; try lia; try ring.
  rewrite IH by lia; ring.
Qed.
Lemma nth_bump : forall i j r z, i <> j -> nth j (bump i r z) 0 = nth j z 0.
Proof. induction i as [|i IH]; intros [|j] r [|x z] N; cbn [bump nth]; auto; contradiction. Qed.
Lemma at_join : forall i j rows z, (i < length z)%nat -> (j < length z)%nat -> i <> j ->
  at_ (map (join i j) rows) (bump i (- nth j z 0) z) = at_ rows z.
Proof.
  intros i j rows z I J N; unfold at_; rewrite map_map; apply map_ext; intro row; unfold join.
  rewrite dot_add, dot_bump, dot_place, nth_bump by (rewrite ?bump_length; assumption); ring.
Qed.
Lemma bump_nonneg : forall i r z, Forall (Rle 0) z -> 0 <= nth i z 0 + r -> Forall (Rle 0) (bump i r z).
Proof.
  induction i as [|i IH]; intros r [|x z] F H; cbn [bump nth] in *; auto; inversion F; subst; constructor; auto.
Qed.
Lemma copositive_sound : forall P n t rows z, copositive P rows n t = true -> length z = n -> Forall (Rle 0) z ->
  0 <= V P (at_ rows z).
Proof.
  intros P n; induction t as [N|i j s IHs t IHt]; intros rows z test len pos; cbn [copositive] in test.
  - apply andb_true_iff in test as [A B]; pose proof (psd_sound n 1 _ z ltac:(lia) B len) as S0.
    rewrite qf_add, qf_scale, value_matrix in S0; pose proof (entries_qf N z A pos).
    unfold V; rewrite <- value_bilinear; lra.
  - rewrite !andb_true_iff, negb_true_iff, !Nat.ltb_lt, Nat.eqb_neq in test; destruct test as [[[[I J] NE] A] B].
    subst n; assert (each : forall k, 0 <= nth k z 0).
    { intro k; destruct (Nat.lt_ge_cases k (length z)) as [L|L].
      - rewrite Forall_forall in pos; apply pos, nth_In, L.
      - rewrite nth_overflow by exact L; lra. }
    destruct (Rle_or_lt (nth j z 0) (nth i z 0)) as [L|L].
    + rewrite <- (at_join i j rows z I J NE); apply IHs; [exact A|apply bump_length|].
      apply bump_nonneg; [exact pos|lra].
    + rewrite <- (at_join j i rows z J I ltac:(auto)); apply IHt; [exact B|apply bump_length|].
      apply bump_nonneg; [exact pos|lra].
Qed.
