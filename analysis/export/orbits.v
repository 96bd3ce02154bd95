(* ---- Functions through points ---- *)

(* Through (x, y) and the points after it, then on with the slope a. *)
Fixpoint through (a x y : R) (pts : list (R * R)) (s : R) : R :=
  match pts with
  | [] => y + a * (s - x)
  | (x', y') :: r => if Rle_dec s x' then y + (y' - y) / (x' - x) * (s - x) else through a x' y' r s
  end.
Fixpoint ascending (x : R) (pts : list (R * R)) : Prop :=
  match pts with [] => True | (x', _) :: r => x < x' /\ ascending x' r end.
Fixpoint steep (a b x y : R) (pts : list (R * R)) : Prop :=
  match pts with
  | [] => True
  | (x', y') :: r => a * (x' - x) <= y' - y <= b * (x' - x) /\ steep a b x' y' r
  end.

Lemma through_start : forall a pts x y, ascending x pts -> through a x y pts x = y.
Proof. intros a [|[x' y'] r] x y; simpl; [intros; ring|intros [H _]; destruct (Rle_dec x x'); [field; lra|lra]]. Qed.
Lemma through_beyond : forall a pts x y x' y' s, ascending x ((x', y') :: pts) -> x' <= s ->
  through a x y ((x', y') :: pts) s = through a x' y' pts s.
Proof.
  intros a pts x y x' y' s [H A] [K| <-]; simpl; destruct (Rle_dec _ x') as [L|L]; try lra.
  rewrite through_start by exact A; field; lra.
Qed.
Lemma through_points : forall a pts x y, ascending x pts ->
  forall p, In p ((x, y) :: pts) -> x <= fst p /\ through a x y pts (fst p) = snd p.
Proof.
  induction pts as [|[x' y'] r IH]; intros x y A p [<-|I]; simpl fst; simpl snd;
    try (split; [lra|now apply through_start]); [destruct I|].
  destruct (IH x' y' (proj2 A) p I) as [L E]; split; [destruct A; lra|]; now rewrite through_beyond.
Qed.
Lemma quotient : forall a b d q, 0 < d -> a * d <= q <= b * d -> a <= q / d <= b.
Proof.
  intros a b d q pos [A B]; split; apply (Rmult_le_reg_r d); try assumption; unfold Rdiv;
    rewrite Rmult_assoc, Rinv_l; lra.
Qed.
Lemma through_steep : forall a c b pts x y, a <= c <= b -> ascending x pts -> steep a b x y pts ->
  slopes_in a b (through c x y pts).
Proof.
  intros a c b pts x y ab; revert x y; induction pts as [|[x' y'] r IH]; intros x y A S s t st.
  - simpl; nra.
  - destruct S as [K S]; assert (Q := quotient a b (x' - x) (y' - y) ltac:(destruct A; lra) K).
    specialize (IH x' y' (proj2 A) S); set (q := (y' - y) / (x' - x)) in *.
    assert (E : y' = y + q * (x' - x)) by (unfold q; field; destruct A; lra).
    simpl; destruct (Rle_dec s x') as [L|L], (Rle_dec t x') as [M|M]; try lra; fold q.
    + nra.
    + pose proof (IH x' t ltac:(lra)) as B; rewrite through_start in B by apply (proj2 A); nra.
    + apply IH; lra.
Qed.

(* In the sector, from points in it: a cone on either side of 0, which is one of the points. *)
Definition cone (l u x y : R) : Prop := (0 <= x /\ l * x <= y <= u * x) \/ (x <= 0 /\ u * x <= y <= l * x).
Fixpoint cones (l u x y : R) (pts : list (R * R)) : Prop :=
  match pts with
  | [] => 0 <= x /\ y = l * x
  | (x', y') :: r => cone l u x' y' /\ (0 <= x \/ x' <= 0) /\ cones l u x' y' r
  end.
Lemma cone_between : forall l u x y x' y' s, l <= u -> cone l u x y -> cone l u x' y' -> 0 <= x \/ x' <= 0 ->
  x < x' -> x <= s <= x' -> cone l u s (y + (y' - y) / (x' - x) * (s - x)).
Proof.
  intros l u x y x' y' s lu A B side lt H.
  set (q := (s - x) / (x' - x)).
  assert (Q : 0 <= q <= 1) by (unfold q; apply quotient; lra).
  replace (y + (y' - y) / (x' - x) * (s - x)) with ((1 - q) * y + q * y') by (unfold q; field; lra).
  assert (S : s = (1 - q) * x + q * x') by (unfold q; field; lra).
  rewrite S; clear S H.
  destruct side as [P|N]; [left|right].
  - assert (l * x <= y <= u * x) by (destruct A; nra); assert (l * x' <= y' <= u * x') by (destruct B; nra).
    split; [|split]; nra.
  - assert (u * x <= y <= l * x) by (destruct A; nra); assert (u * x' <= y' <= l * x') by (destruct B; nra).
    split; [|split]; nra.
Qed.
Lemma through_cone : forall l u pts x y, l <= u -> ascending x pts -> cone l u x y -> cones l u x y pts ->
  forall s, x <= s -> cone l u s (through l x y pts s).
Proof.
  intros l u pts x y lu; revert x y; induction pts as [|[x' y'] r IH]; intros x y A C S s xs.
  - destruct S as [P ->]; left; simpl; split; [lra|nra].
  - destruct S as [C' [side S]], A as [lt A]; simpl; destruct (Rle_dec s x') as [L|L].
    + apply cone_between; auto.
    + apply IH; auto; lra.
Qed.
(* Between two of the points that it goes through. *)
Lemma through_segment : forall a i pts x y s, ascending x pts -> (i < length pts)%nat ->
  let p := nth i ((x, y) :: pts) (0, 0) in let q := nth i pts (0, 0) in
  fst p <= s <= fst q -> through a x y pts s = snd p + (snd q - snd p) / (fst q - fst p) * (s - fst p).
Proof.
  intros a; induction i as [|i IH]; intros [|[x' y'] r] x y s A L p q I; cbn [length] in L; try lia.
  - unfold p, q in *; cbn [nth fst snd] in *; cbn [through]; destruct (Rle_dec s x'); [reflexivity|lra].
  - assert (X : x' <= fst p).
    { apply (through_points a r x' y' (proj2 A)), (nth_In ((x', y') :: r)); cbn [length]; lia. }
    rewrite through_beyond by (auto; lra); apply (IH r x' y' s (proj2 A) ltac:(lia)); exact I.
Qed.
Definition with_ray (l x y : R) (pts : list (R * R)) (s : R) : R :=
  if Rle_dec x s then through l x y pts s else l * s.

Definition oddly (f : R -> R) (s : R) : R := (f s - f (- s)) / 2.
Lemma oddly_odd : forall f, odd (oddly f).
Proof. intros f y; unfold oddly; rewrite Ropp_involutive; field. Qed.
Lemma oddly_steep : forall a b f, slopes_in a b f -> slopes_in a b (oddly f).
Proof.
  intros a b f S s t st; unfold oddly; pose proof (S s t st); pose proof (S (- t) (- s) ltac:(lra)); lra.
Qed.
(* Through points of which each has its opposite. *)
Lemma oddly_points : forall f pts, (forall p, In p pts -> f (fst p) = snd p) ->
  map (fun p => (- fst p, - snd p)) pts = rev pts -> forall p, In p pts -> oddly f (fst p) = snd p.
Proof.
  intros f pts H M p I; unfold oddly; rewrite (H p I).
  pose proof (in_map (fun p => (- fst p, - snd p)) pts p I) as J; rewrite M, <- in_rev in J.
  pose proof (H _ J) as E; cbn [fst snd] in E; rewrite E; field.
Qed.
Lemma in_sector_of_slopes : forall a b f, slopes_in a b f -> f 0 = 0 -> in_sector a b f.
Proof.
  intros a b f S Z; split; [exact Z|]; intro y; destruct (Rtotal_order y 0) as [H|[->|H]].
  - pose proof (S y 0 H); rewrite Z in *; nra.
  - rewrite Z; lra.
  - pose proof (S 0 y H); rewrite Z in *; nra.
Qed.
Lemma in_sector_of_cone : forall l u f, (forall s, cone l u s (f s)) -> in_sector l u f.
Proof.
  intros l u f C; split.
  - destruct (C 0) as [[_ H]|[_ H]]; lra.
  - intro y; destruct (C y) as [[P H]|[N H]]; nra.
Qed.
Lemma oddly_cone : forall l u f, (forall s, cone l u s (f s)) -> forall s, cone l u s (oddly f s).
Proof.
  intros l u f C s; unfold oddly; destruct (C s) as [[P H]|[P H]], (C (- s)) as [[Q K]|[Q K]].
  - left; assert (s = 0) as -> by lra; split; lra.
  - left; split; lra.
  - right; split; lra.
  - left; assert (s = 0) as -> by lra; split; lra.
Qed.
Lemma with_ray_cone : forall l u pts x y, l <= u -> x <= 0 -> ascending x pts -> cone l u x y -> cones l u x y pts ->
  forall s, cone l u s (with_ray l x y pts s).
Proof.
  intros l u pts x y lu neg A C S s; unfold with_ray; destruct (Rle_dec x s) as [L|L].
  - now apply (through_cone l u pts x y).
  - right; split; [lra|nra].
Qed.
Lemma steep_more : forall a b a' b' pts x y, a' <= a -> b <= b' -> ascending x pts -> steep a b x y pts -> steep a' b' x y pts.
Proof.
  intros a b a' b' pts; induction pts as [|[x' y'] r IH]; intros x y A B C S; [exact I|]; destruct C as [L C], S as [K S].
  cbn [steep]; split; [split; nra|now apply IH].
Qed.
Lemma steep_some : forall l pts x y, ascending x pts -> exists a b, a <= l <= b /\ steep a b x y pts.
Proof.
  intros l pts; induction pts as [|[x' y'] r IH]; intros x y A; [exists l, l; split; [lra|exact I]|].
  destruct A as [L A]; destruct (IH x' y' A) as [a [b [B S]]]; set (q := (y' - y) / (x' - x)).
  assert (E : y' - y = q * (x' - x)) by (unfold q; field; lra).
  pose proof (Rmin_l a q); pose proof (Rmin_r a q); pose proof (Rmax_l b q); pose proof (Rmax_r b q).
  exists (Rmin a q), (Rmax b q); split; [lra|]; cbn [steep]; rewrite E; split; [split; nra|].
  apply (steep_more a b); auto.
Qed.
Lemma with_ray_steep : forall l pts x y, y = l * x -> ascending x pts -> exists a b, slopes_in a b (with_ray l x y pts).
Proof.
  intros l pts x y E A; destruct (steep_some l pts x y A) as [a [b [lb S]]]; exists a, b; intros s t st.
  unfold with_ray; pose proof (through_steep a l b pts x y lb A S) as T.
  destruct (Rle_dec x s) as [K|K], (Rle_dec x t) as [M|M]; try lra; [now apply T| |nra].
  assert (B : a * (t - x) <= through l x y pts t - y <= b * (t - x)).
  { destruct M as [M| <-]; [|rewrite through_start by exact A; lra].
    pose proof (T x t M) as N; rewrite through_start in N by exact A; exact N. }
  rewrite E in *; split; nra.
Qed.
Lemma with_ray_points : forall l pts x y, ascending x pts ->
  forall p, In p ((x, y) :: pts) -> with_ray l x y pts (fst p) = snd p.
Proof.
  intros l pts x y A p I; destruct (through_points l pts x y A p I) as [L E]; unfold with_ray.
  destruct (Rle_dec x (fst p)); [exact E|lra].
Qed.

(* ---- A solution that repeats ---- *)

Definition repeated (samples : list R) (t : nat) : R := nth (t mod length samples) samples 0.
Lemma repeated_on : forall samples k t, samples <> [] ->
  repeated samples (k + t) = repeated samples (k + t mod length samples).
Proof.
  intros samples k t some; unfold repeated; rewrite Nat.add_mod_idemp_r; [reflexivity|].
  destruct samples; simpl; [contradiction|lia].
Qed.
Lemma repeated_again : forall samples k r, (r < length samples)%nat ->
  repeated samples (k * length samples + r) = nth r samples 0.
Proof.
  intros samples k r small; unfold repeated.
  rewrite Nat.add_comm, Nat.mod_add, Nat.mod_small by lia; reflexivity.
Qed.
Lemma repeated_moves : forall samples r r', (r < length samples)%nat -> (r' < length samples)%nat ->
  nth r samples 0 <> nth r' samples 0 -> forall c, ~ Un_cv (repeated samples) c.
Proof.
  intros samples r r' A B apart c lim.
  set (d := Rabs (nth r samples 0 - nth r' samples 0)).
  assert (dpos : 0 < d) by (apply Rabs_pos_lt; lra).
  destruct (lim (d / 2) ltac:(lra)) as [T H].
  pose proof (H (T * length samples + r)%nat ltac:(nia)) as E; pose proof (H (T * length samples + r')%nat ltac:(nia)) as F.
  rewrite repeated_again in E, F by assumption; unfold R_dist in E, F.
  assert (d < d / 2 + d / 2); [|lra].
  unfold d at 1; replace (nth r samples 0 - nth r' samples 0) with ((nth r samples 0 - c) - (nth r' samples 0 - c)) by ring.
  apply Rle_lt_trans with (1 := Rabs_triang _ _); rewrite Rabs_Ropp; lra.
Qed.
Lemma repeated_stays : forall samples r, (r < length samples)%nat -> nth r samples 0 <> 0 -> ~ Un_cv (repeated samples) 0.
Proof.
  intros samples r A nz lim; destruct (lim _ (Rabs_pos_lt _ nz)) as [T H].
  pose proof (H (T * length samples + r)%nat ltac:(nia)) as E.
  rewrite repeated_again in E by assumption; unfold R_dist in E; rewrite Rminus_0_r in E; lra.
Qed.
Lemma repeated_all : forall (P : R -> Prop) samples t, samples <> [] -> Forall P samples -> P (repeated samples t).
Proof.
  intros P samples t some F; rewrite Forall_forall in F; unfold repeated; apply F, nth_In, Nat.mod_upper_bound.
  destruct samples; [contradiction|discriminate].
Qed.

(* A vector by its components. *)
Definition listed (n : nat) (f : nat -> R) : list R := map f (seq 0 n).
Lemma listed_length : forall n f, length (listed n f) = n.
Proof. intros; unfold listed; now rewrite map_length, seq_length. Qed.
Lemma nth_listed : forall (f : nat -> R) n i, (i < n)%nat -> nth i (map f (seq 0 n)) 0 = f i.
Proof.
  intros f n i L; rewrite (nth_indep _ 0 (f 0%nat)) by (now rewrite map_length, seq_length).
  now rewrite map_nth, seq_nth.
Qed.
Lemma listed_again : forall s, listed (length s) (fun i => nth i s 0) = s.
Proof.
  unfold listed.
  induction s as [|x s IH]; [reflexivity|]; cbn [length seq map nth]; f_equal; rewrite <- seq_shift, map_map; exact IH.
Qed.
