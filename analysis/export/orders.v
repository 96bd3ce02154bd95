(* ---- Forms of samples of one nonlinearity, by the orders that the samples and 0 may have ---- *)

(* (phi(s) - l s, k s - phi(s)) of all samples, first parts first; and the form M of it. *)
Definition window (l k : R) (phi : R -> R) (samples : list R) : list R :=
  map (fun s => phi s - l * s) samples ++ map (fun s => k * s - phi s) samples.
Definition nonneg_on_samples (M : list (list Z)) (count : nat) (l k : R) (phi : R -> R) : Prop :=
  forall samples, length samples = count -> 0 <= V M (window l k phi samples).

Fixpoint insertions (i : nat) (p : list nat) : list (list nat) :=
  (i :: p) :: match p with j :: q => map (cons j) (insertions i q) | [] => [] end.
Fixpoint orders (n : nat) : list (list nat) :=
  match n with O => [[]] | S m => flat_map (insertions n) (orders m) end.
Fixpoint ascends (f : nat -> R) (p : list nat) : Prop :=
  match p with i :: q => match q with j :: _ => f i <= f j | [] => True end /\ ascends f q | [] => True end.
Lemma inserted : forall f i p, ascends f p -> exists q, In q (insertions i p) /\ ascends f q /\
  (forall j, hd_error p = Some j -> f j <= f i -> hd_error q = Some j).
Proof.
  intros f i; induction p as [|j p IH]; intro A.
  - exists [i]; repeat split; [left; reflexivity|discriminate].
  - destruct (Rle_dec (f j) (f i)) as [L|L].
    + destruct A as [B A]; destruct (IH A) as [q [I [C H]]].
      exists (j :: q); split; [right; apply in_map; exact I|split; [split; [|exact C]|]].
      * destruct p as [|m p]; cbn [insertions] in I.
        { destruct I as [<-|[]]; exact L. }
        destruct (Rle_dec (f m) (f i)) as [K|K].
        { pose proof (H m eq_refl K) as E; destruct q as [|e q]; [discriminate|]; injection E as ->; exact B. }
        destruct I as [<-|I]; [exact L|].
        apply in_map_iff in I as [r [<- _]]; exact B.
      * intros e E _; exact E.
    + exists (i :: j :: p); split; [left; reflexivity|split; [split; [lra|exact A]|]].
      intros e E K; injection E as <-; contradiction.
Qed.
Lemma some_order : forall f n, exists p, In p (orders n) /\ ascends f p.
Proof.
  intro f; induction n as [|n [p [I A]]]; [exists []; repeat split; left; reflexivity|].
  destruct (inserted f (S n) p A) as [q [J [B _]]]; exists q; split; [|exact B].
  cbn [orders]; apply in_flat_map; exists p; auto.
Qed.

(* Steps from one to the next, and where one stands. *)
Fixpoint steps (f : nat -> R) (p : list nat) : list R :=
  match p with i :: (j :: _) as q => (f j - f i) :: steps f q | _ => [] end.
Fixpoint place (i : nat) (p : list nat) : nat := match p with j :: q => if (i =? j)%nat then O else S (place i q) | [] => O end.
Lemma total_steps : forall f p j w, (j < length p)%nat ->
  dot (repeat 1%Z j) (steps f p ++ w) = f (nth j p O) - f (nth O p O).
Proof.
  intro f; induction p as [|i p IH]; intros [|j] w L; cbn [length] in L; try lia; cbn [repeat dot nth]; [ring|].
  destruct p as [|m p]; cbn [length] in L; [lia|].
  change (steps f (i :: m :: p) ++ w) with ((f m - f i) :: (steps f (m :: p) ++ w)); cbn [dot].
  rewrite IH by (cbn [length]; lia); cbn [nth]; ring.
Qed.
Lemma steps_length : forall f p, length (steps f p) = pred (length p).
Proof.
  intro f; induction p as [|i [|j p] IH]; [reflexivity|reflexivity|].
  change (S (length (steps f (j :: p))) = S (length p)); now rewrite IH.
Qed.
Lemma dot_zeros : forall n v x y, length x = n -> dot (repeat 0%Z n ++ v) (x ++ y) = dot v y.
Proof.
  induction n as [|n IH]; intros v [|a x] y L; try discriminate; [reflexivity|].
  injection L as L; cbn [repeat app dot]; rewrite IH by exact L; ring.
Qed.
Lemma steps_nonneg : forall f g p, ascends f p -> (forall i j, f i <= f j -> g i <= g j) -> Forall (Rle 0) (steps g p).
Proof.
  intros f g; induction p as [|i [|j p] IH]; intros A H; try apply Forall_nil.
  destruct A as [B A]; apply Forall_cons; [pose proof (H i j B); lra|exact (IH A H)].
Qed.

(* Of T samples 1 to T, and 0 for 0, in the order p, each times its sign: rows over the steps. *)
Definition sign_of (signs : list Z) (i : nat) : Z := nth (pred i) signs 1%Z.
Definition row_in (signs : list Z) (p : list nat) (i : nat) : list Z :=
  scale (sign_of signs i) (add (repeat 1%Z (place i p)) (scale (-1) (repeat 1%Z (place O p)))).
Definition rows_in (T : nat) (signs : list Z) (p : list nat) : list (list Z) :=
  map (row_in signs p) (seq 1 T) ++ map (fun i => repeat 0%Z T ++ row_in signs p i) (seq 1 T).
Definition complete (T : nat) (p : list nat) : bool :=
  (length p =? S T)%nat &&
  forallb (fun i => (place i p <? length p)%nat && (nth (place i p) p O =? i)%nat) (seq 0 (S T)).
Fixpoint all_positive (M : list (list Z)) (T : nat) (cases : list (list Z * list nat)) (ts : list halves) : bool :=
  match cases, ts with
  | [], _ => true
  | (signs, p) :: c, t :: r => complete T p && copositive M (rows_in T signs p) (2 * T) t && all_positive M T c r
  | _, [] => false
  end.
Fixpoint all_signs (T : nat) : list (list Z) :=
  match T with O => [[]] | S n => map (cons 1%Z) (all_signs n) ++ map (cons (-1)%Z) (all_signs n) end.
Definition cases (odd : bool) (T : nat) : list (list Z * list nat) :=
  if odd then flat_map (fun signs => map (fun p => (signs, O :: p)) (orders T)) (all_signs T)
  else map (fun p => ([], p)) (flat_map (insertions O) (orders T)).

Lemma in_case : forall M T signs p t u v, complete T p = true -> copositive M (rows_in T signs p) (2 * T) t = true ->
  u O = 0 -> v O = 0 -> Forall (Rle 0) (steps u p) -> Forall (Rle 0) (steps v p) ->
  0 <= V M (map (fun i => IZR (sign_of signs i) * u i) (seq 1 T) ++ map (fun i => IZR (sign_of signs i) * v i) (seq 1 T)).
Proof.
  intros M T signs p t u v C test u0 v0 pu pv; unfold complete in C.
  apply andb_true_iff in C as [L C]; apply Nat.eqb_eq in L; rewrite forallb_forall in C.
  assert (at_place : forall f i w, f O = 0 -> In i (seq 1 T) ->
    dot (row_in signs p i) (steps f p ++ w) = IZR (sign_of signs i) * f i).
  { intros f i w f0 I; apply in_seq in I; unfold row_in.
    pose proof (C i ltac:(apply in_seq; lia)) as A; pose proof (C O ltac:(apply in_seq; lia)) as B.
    apply andb_true_iff in A as [A1 A2], B as [B1 B2]; apply Nat.ltb_lt in A1, B1; apply Nat.eqb_eq in A2, B2.
    rewrite dot_scale, dot_add, dot_scale, !total_steps by assumption; rewrite A2, B2, f0; ring. }
  replace (map (fun i => IZR (sign_of signs i) * u i) (seq 1 T) ++ map (fun i => IZR (sign_of signs i) * v i) (seq 1 T))
    with (at_ (rows_in T signs p) (steps u p ++ steps v p)).
  - apply (copositive_sound M (2 * T) t); [exact test| |now apply Forall_app].
    rewrite app_length, !steps_length; lia.
  - unfold at_, rows_in; rewrite map_app, !map_map; f_equal; apply map_ext_in; intros i I; [now apply at_place|].
    rewrite dot_zeros by (rewrite steps_length; lia).
    rewrite <- (app_nil_r (steps v p)); now apply at_place.
Qed.
Lemma case_of : forall M T cs ts, all_positive M T cs ts = true -> forall signs p, In (signs, p) cs ->
  complete T p = true /\ exists t, copositive M (rows_in T signs p) (2 * T) t = true.
Proof.
  intros M T; induction cs as [|[s q] cs IH]; intros [|t ts] test signs p I; try discriminate; try contradiction.
  cbn [all_positive] in test; rewrite !andb_true_iff in test; destruct test as [[A B] D].
  destruct I as [E|I]; [injection E as <- <-; split; [exact A|exists t; exact B]|exact (IH ts D signs p I)].
Qed.

Definition sample (samples : list R) (i : nat) : R := match i with O => 0 | S j => nth j samples 0 end.
Lemma map_samples : forall (g : R -> R) samples, map g samples = map (fun i => g (sample samples i)) (seq 1 (length samples)).
Proof.
  intros g; induction samples as [|s r IH]; [reflexivity|]; cbn [length seq map]; f_equal.
  rewrite IH, <- (seq_shift (length r) 1), map_map; apply map_ext_in; intros i I; apply in_seq in I; destruct i as [|i]; [lia|reflexivity].
Qed.
Lemma rises_with : forall l k phi, slopes_in l k phi -> forall s t, s <= t ->
  phi s - l * s <= phi t - l * t /\ k * s - phi s <= k * t - phi t.
Proof. intros l k phi S s t [L| ->]; [|lra]; pose proof (S s t L); lra. Qed.

Theorem orders_sound : forall M T ts l k phi, all_positive M T (cases false T) ts = true ->
  phi 0 = 0 -> slopes_in l k phi -> nonneg_on_samples M T l k phi.
Proof.
  intros M T ts l k phi test Z S samples <-; unfold window; rewrite !map_samples.
  set (f := sample samples); destruct (some_order f (length samples)) as [q [I A]].
  destruct (inserted f O q A) as [p [J [B _]]].
  destruct (case_of _ _ _ _ test [] p) as [C [t D]].
  { apply in_map; apply in_flat_map; exists q; auto. }
  pose proof (in_case M _ [] p t (fun i => phi (f i) - l * f i) (fun i => k * f i - phi (f i)) C D) as H.
  replace (map (fun i => phi (f i) - l * f i) (seq 1 (length samples)) ++ map (fun i => k * f i - phi (f i)) (seq 1 (length samples)))
    with (map (fun i => IZR (sign_of [] i) * (phi (f i) - l * f i)) (seq 1 (length samples))
      ++ map (fun i => IZR (sign_of [] i) * (k * f i - phi (f i))) (seq 1 (length samples))).
  - assert (f0 : f O = 0) by reflexivity.
    apply H; try (rewrite f0, Z; ring);
      apply (steps_nonneg f); auto; intros i j L; pose proof (rises_with l k phi S _ _ L); lra.
  - f_equal; apply map_ext; intro i; unfold sign_of; destruct (pred i); simpl; ring.
Qed.

Lemma some_signs : forall samples, exists signs, In signs (all_signs (length samples)) /\
  forall i, sample samples i = IZR (sign_of signs i) * Rabs (sample samples i) /\ (sign_of signs i = 1 \/ sign_of signs i = -1)%Z.
Proof.
  induction samples as [|s r [signs [I H]]].
  - exists []; split; [left; reflexivity|]; intro i; unfold sign_of.
    replace (sample [] i) with 0 by (destruct i as [|[|i]]; reflexivity); rewrite Rabs_R0.
    destruct (pred i); simpl; split; auto; ring.
  - destruct (Rle_or_lt 0 s) as [P|N].
    + exists (1%Z :: signs); split; [apply in_or_app; left; now apply in_map|].
      intros [|[|i]]; [unfold sign_of; simpl; rewrite Rabs_R0; split; auto; ring|
        unfold sign_of; simpl; rewrite Rabs_right by lra; split; auto; ring|exact (H (S i))].
    + exists ((-1)%Z :: signs); split; [apply in_or_app; right; now apply in_map|].
      intros [|[|i]]; [unfold sign_of; simpl; rewrite Rabs_R0; split; auto; ring|
        unfold sign_of; simpl; rewrite Rabs_left by lra; split; auto; ring|exact (H (S i))].
Qed.
Theorem odd_orders_sound : forall M T ts l k phi, all_positive M T (cases true T) ts = true ->
  phi 0 = 0 -> slopes_in l k phi -> odd phi -> nonneg_on_samples M T l k phi.
Proof.
  intros M T ts l k phi test Z S O_ samples <-; unfold window; rewrite !map_samples.
  set (f := fun i => Rabs (sample samples i)); destruct (some_order f (length samples)) as [q [I A]].
  destruct (some_signs samples) as [signs [J H]].
  assert (B : ascends f (O :: q)).
  { destruct q as [|j q]; cbn [ascends] in *; [auto|split; [|exact A]].
    unfold f at 1; cbn [sample]; rewrite Rabs_R0; apply Rabs_pos. }
  destruct (case_of _ _ _ _ test signs (O :: q)) as [C [t D]].
  { unfold cases; apply in_flat_map; exists signs; split; [exact J|]; apply in_map with (f := fun p => (signs, O :: p)); exact I. }
  pose proof (in_case M _ signs (O :: q) t (fun i => phi (f i) - l * f i) (fun i => k * f i - phi (f i)) C D) as E.
  assert (turn : forall i, phi (sample samples i) = IZR (sign_of signs i) * phi (f i)).
  { intro i; destruct (H i) as [F [G|G]]; rewrite F, G; fold (f i); [rewrite !Rmult_1_l; reflexivity|].
    replace (-1 * f i) with (- f i) by ring; rewrite O_; ring. }
  match goal with |- 0 <= V M ?w => replace w with
    (map (fun i => IZR (sign_of signs i) * (phi (f i) - l * f i)) (seq 1 (length samples))
      ++ map (fun i => IZR (sign_of signs i) * (k * f i - phi (f i))) (seq 1 (length samples))) end.
  - assert (f0 : f O = 0) by (unfold f; cbn [sample]; apply Rabs_R0).
    apply E; try (rewrite f0, Z; ring);
      apply (steps_nonneg f); auto; intros i j L; pose proof (rises_with l k phi S _ _ L); lra.
  - f_equal; apply map_ext; intro i; rewrite turn; rewrite (proj1 (H i)) at 1; fold (f i); ring.
Qed.

(* Re (m X conj D) - W* M W / q with W = (D, z D, .., - X, - z X, ..), and the theorem relied on. *)
Definition order_cone (q : R) (M : list (list Z)) (T : nat) (hs : list tap) (w : R) (X D : C) : R :=
  let W := map (fun i => cmul (cpow (circle w) i) D) (seq 0 T)
    ++ map (fun i => cmul (cpow (circle w) i) (cmul (-1, 0) X)) (seq 0 T) in
  with_multiplier (zames_falb_steps hs) w X D - (V M (map fst W) + V M (map snd W)) / q.
Definition slope_class (with_odd : bool) (l k : R) (phi : R -> R) : Prop :=
  phi 0 = 0 /\ slopes_in l k phi /\ (with_odd = true -> odd phi).
Definition order_cone_criterion : Prop := forall num den l k q M T hs with_odd phi xi,
  proper num den l -> (length num < length den)%nat -> l < k -> 0 < q -> mass (map tap_weight hs) <= 1 ->
  Forall (fun h => match h with (_, i, _) => i <> O end) hs ->
  (Forall (fun h => 0 <= tap_weight h) hs \/ with_odd = true) ->
  in_unit_disc (closed num den l) -> over_frequencies circle (order_cone q M T hs) num den l k ->
  (forall f, slope_class with_odd l k f -> nonneg_on_samples M T l k f) ->
  slope_class with_odd l k phi -> steps_of num den phi xi -> Un_cv xi 0.
